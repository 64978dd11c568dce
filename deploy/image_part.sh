#!/bin/sh
# Installs the packages of deploy/requirements-NAME.lock that /opt/voa lacks, and puts the new files into /added, so that
# images which share packages share their layers: deploy/Dockerfile calls `image_part.sh NAME`.
set -eu
touch /before
# Without dependencies: the locks are complete, and lack what no module of these images imports (requirements-unused.txt).
tools/bin/pip --python /opt/voa/bin/python install --quiet --no-compile --no-deps --require-hashes \
  -r "deploy/requirements-$1.lock"
# The tests of other projects stay here.
find /opt/voa/lib -type d -name tests -prune -exec rm -r {} +
# Of these packages only a part is imported, which Dockerfile compiles; the other half of their bytecode is 35 MB.
find /opt/voa/lib -name '*.py' -cnewer /before | grep -Ev '/(numba|numpy|scipy)/' >/sources
# Bytecode that is valid whatever times the files get.
/opt/voa/bin/python -m compileall -q --invalidation-mode unchecked-hash -i /sources
mkdir -p /added
cd /opt/voa
find . -cnewer /before ! -type d -print0 | tar --create --null --files-from=- | tar --extract --directory=/added
chmod -R a+rX,go-w /opt/voa /added
