#!/usr/bin/env bash
# Builds the images of the service, the console and the fleet without Docker and without the network, and runs them as
# deploy/compose.yml would: `make image`.
#
#   BASE_IMAGE=...   a base with Python 3.11 (default: the Dockerfile's, else one made with debootstrap)
#   IMAGE_ARCHIVE=F  keep the images as an archive for `docker load` or `podman load`
set -euo pipefail
cd "$(dirname "$0")/.."

python=.venv/bin/python
base_tar=$PWD/build/base-bookworm.tar
wheels=deploy/wheelhouse
image=localhost/voa:latest
name=voa-image-check
most_start_ms=2000  # the service listens after so many milliseconds at most
export DISABLE_HC_SYSTEMD=true  # podman: the health check is run from here, not by a timer

say() { printf '\n== %s\n' "$*"; }
fail() { printf 'make image: %s\n' "$*" >&2; exit 1; }

need() {  # need COMMAND...: install what is missing, or say how; each command is named like its Debian package
  local missing=() command
  # Files alone: `command -v` would find the functions below, which have the names of two commands.
  for command in "$@"; do type -P "$command" >/dev/null || missing+=("$command"); done
  [ ${#missing[@]} -eq 0 ] && return
  if [ "$(id -u)" -ne 0 ] || ! type -P apt-get >/dev/null; then
    fail "${missing[*]} missing; on Debian: sudo apt-get install --no-install-recommends ${missing[*]}"
  fi
  say "installing ${missing[*]}"
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# An own store, which goes away afterwards. Where the file system cannot be laid over another, each layer is a copy.
choose_storage() {
  mkdir -p "$work"/trial/{lower,upper,work,merged}
  driver=vfs
  if mount -t overlay voa-trial -o "lowerdir=$work/trial/lower,upperdir=$work/trial/upper,workdir=$work/trial/work" \
    "$work/trial/merged" 2>/dev/null; then
    umount "$work/trial/merged"
    driver=overlay
  fi
}

buildah() { command buildah --root "$work/store" --runroot "$work/run" --storage-driver "$driver" "$@"; }
podman() {
  command podman --root "$work/store" --runroot "$work/run" --tmpdir "$work/tmp" --storage-driver "$driver" \
    --runtime runc --cgroup-manager cgroupfs "$@"
}

clean() {
  podman rm --force --all >/dev/null 2>&1 || true
  if mountpoint --quiet "$work/store/overlay"; then umount --recursive "$work/store/overlay" || true; fi
  rm -rf "$work"
  rm -f "$wheels"/*.whl
}

gather_wheels() {
  say "gathering wheels for an offline build"
  rm -f "$wheels"/*.whl
  # The packages of the console hold those of the fleet.
  "$python" -m pip download --quiet --disable-pip-version-check --require-hashes --no-deps --only-binary :all: \
    --dest "$wheels" -r deploy/requirements-build.lock -r deploy/requirements-service.lock -r deploy/requirements-console.lock
  du -sh "$wheels"
}

make_base() {  # Debian with Python, from the mirror that this machine uses; no mirror's name stays in it
  if [ ! -s "$base_tar" ]; then
    need debootstrap
    say "no container registry answers: making a base image with debootstrap (make clean forgets it)"
    local mirror=""
    if type -P apt-get >/dev/null; then
      # shellcheck disable=SC2016  # apt fills this in
      mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Codename: bookworm' \
        'Component: main' | sed 1q)
    fi
    debootstrap --variant=minbase --include=python3-venv bookworm "$work/base" ${mirror:+"$mirror"} >"$work/debootstrap.log" ||
      { tail -n 20 "$work/debootstrap.log" >&2; fail "debootstrap failed"; }
    rm -rf "$work/base"/{var/cache/apt/*,var/lib/apt/lists/*,var/log/*,usr/share/{doc,man,locale}/*}
    rm -f "$work/base"/etc/{hostname,resolv.conf,apt/sources.list}
    mkdir -p "$(dirname "$base_tar")"
    tar --create --one-file-system --directory "$work/base" --file "$base_tar" .
    rm -rf "$work/base"
  fi
  podman import --quiet "$base_tar" localhost/base:bookworm >/dev/null
  BASE_IMAGE=localhost/base:bookworm
}

choose_base() {
  if [ -z "${BASE_IMAGE:-}" ]; then
    BASE_IMAGE=$(sed -n 's/^ARG BASE_IMAGE=//p' deploy/Dockerfile)
    timeout 60 "$(type -P buildah)" --root "$work/store" --runroot "$work/run" --storage-driver "$driver" \
      pull --quiet "$BASE_IMAGE" >/dev/null 2>&1 || make_base
  fi
  echo "base image: $BASE_IMAGE, $(megabytes "$BASE_IMAGE")"
}

megabytes() { echo "$(($(podman image inspect --format '{{.Size}}' "$1") / 1000000)) MB"; }

build() {  # build TARGET TAG: stages that were built for an earlier target are taken from it
  local started=$SECONDS
  buildah build --layers --isolation chroot --format docker --file deploy/Dockerfile --target "$1" --tag "$2" \
    --build-arg BASE_IMAGE="$BASE_IMAGE" --build-arg PIP_NO_INDEX=1 \
    --build-arg VERSION="$(sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)" . >"$work/build.log" 2>&1 ||
    { tail -n 40 "$work/build.log" >&2; fail "the build of the $1 failed"; }
  echo "$1: built in $((SECONDS - started)) s, $(megabytes "$2")"
}

hardened() {  # hardened ARGUMENTS...: the profile of deploy/compose.yml
  podman run --detach --name "$name" --read-only --read-only-tmpfs=false --tmpfs /tmp --cap-drop ALL \
    --security-opt no-new-privileges --ulimit nofile=1024:1024 --ulimit nproc=1000:1000 --volume voa-data:/data \
    "$@" "$image" >/dev/null
}

show_log() { podman logs "$name" 2>&1 | tail -n 20 | cut -c -2000; }

check() {  # check work|recall: start a container on the volume, send it requests, stop it
  local port started
  port=$("$python" -c 'import socket; s = socket.create_server(("127.0.0.1", 0)); print(s.getsockname()[1])')
  started=$(date +%s%N)
  # The host's network, because a bridge needs more than a sandbox has; so on loopback, and on a port that is free.
  hardened --network host --env VOA_HOST=127.0.0.1 --env VOA_PORT="$port"
  echo "  podman took $((($(date +%s%N) - started) / 1000000)) ms"
  started=$(date +%s%N)
  until "$python" -c "import socket; socket.create_connection(('127.0.0.1', $port), 1)" 2>/dev/null; do
    [ "$(podman inspect --format '{{.State.Running}}' "$name")" = true ] || { show_log; fail "it ended"; }
    [ $(($(date +%s%N) - started)) -lt 60000000000 ] || { show_log; fail "it does not listen"; }
  done
  echo "  listening $((($(date +%s%N) - started) / 1000000)) ms later"
  "$python" deploy/check_container.py "$1" "http://127.0.0.1:$port" "$work/session.json" ||
    { show_log; fail "the container did not do its work"; }
  podman healthcheck run "$name" || fail "its own health check failed"
  local pid
  pid=$(podman inspect --format '{{.State.Pid}}' "$name")
  awk '/^Uid|^CapEff|^NoNewPrivs|^VmRSS|^VmHWM/ {$1 = $1; printf "  %s\n", $0}' "/proc/$pid/status"
  stop
}

stop() {
  local started
  started=$(date +%s%N)
  podman stop --time 30 "$name" >/dev/null
  echo "  stopped after $((($(date +%s%N) - started) / 1000000)) ms, exit code $(podman inspect --format '{{.State.ExitCode}}' "$name")"
  podman rm "$name" >/dev/null
}

[ -x "$python" ] || fail "there is no .venv: make setup"
[ "$(id -u)" -eq 0 ] || fail "without Docker this needs root (chroot, debootstrap): sudo make image. With Docker: docker build -f deploy/Dockerfile -t voa ."
need buildah podman runc
work=$(mktemp -d "${TMPDIR:-/var/tmp}/voa-image.XXXXXX")
trap clean EXIT

gather_wheels
choose_base
build
say "as it is shipped, without a network"
hardened --network none
for _ in $(seq 60); do podman healthcheck run "$name" >/dev/null 2>&1 && break; sleep 0.5; done
podman healthcheck run "$name" || { show_log; fail "it never became healthy"; }
echo "  healthy on 0.0.0.0:8000"
stop
say "the main job"
check work
say "a new container on the same volume"
check recall
if [ -n "${IMAGE_ARCHIVE:-}" ]; then
  podman save --quiet --format docker-archive --output "$IMAGE_ARCHIVE" "$image"
  say "kept as $IMAGE_ARCHIVE"
fi
say "the image builds, runs hardened and keeps what it answered"
