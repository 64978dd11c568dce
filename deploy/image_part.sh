#!/bin/sh
# Installs the packages of deploy/requirements-NAME.lock that /opt/voa lacks, and puts the new files into /added, so that
# images which share packages share their layers: deploy/Dockerfile calls `image_part.sh NAME`.
set -eu
files() { find /opt/voa ! -type d | sort; }
files >/before
# Without dependencies: the locks are complete, and lack what no module of these images imports (requirements-unused.txt).
tools/bin/pip --python /opt/voa/bin/python install --quiet --no-compile --no-deps --require-hashes \
  -r "deploy/requirements-$1.lock"
# The tests of other projects stay here.
find /opt/voa/lib -type d -name tests -prune -exec rm -r {} +
# Of these packages only a part is imported, and Dockerfile compiles that part: the bytecode of the rest is 35 MB.
files | comm -13 /before - | grep '\.py$' | grep -Ev '/(numba|numpy|scipy)/' >/sources
# Bytecode that is valid whatever times the files get.
/opt/voa/bin/python -m compileall -q --invalidation-mode unchecked-hash -i /sources
chmod -R a+rX,go-w /opt/voa
rm -rf /added
mkdir /added
files | comm -13 /before - | sed 's|^/opt/voa/||' | tar --create --directory=/opt/voa --files-from=- | tar --extract --directory=/added
