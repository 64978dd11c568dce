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
images=localhost/voa  # and -console, -fleet
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

# An own store, which goes away afterwards. Where file systems cannot be laid over each other, each layer is a copy.
driver=vfs
choose_storage() {
  mkdir -p "$work"/trial/{lower,upper,work,merged}
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
  umount --recursive "$work/store/overlay" 2>/dev/null || true
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

hardened() {  # hardened NAME IMAGE [OPTION ...] -- [ARGUMENT ...]: run with the profile of deploy/compose.yml
  local name=$1 image=$2 options=()
  shift 2
  while [ "$1" != -- ]; do options+=("$1"); shift; done
  shift
  podman run --name "$name" --read-only --read-only-tmpfs=false --tmpfs /tmp --cap-drop ALL \
    --security-opt no-new-privileges --ulimit nofile=1024:1024 --ulimit nproc=1000:1000 "${options[@]}" "$image" "$@"
}

free_port() { "$python" -c 'import socket; s = socket.create_server(("127.0.0.1", 0)); print(s.getsockname()[1])'; }
now_ms() { echo $(($(date +%s%N) / 1000000)); }
show_log() { podman logs "$1" 2>&1 | tail -n 20 | cut -c -2000; }
wrong() { show_log "$1"; fail "$2"; }

stop() {  # stop NAME
  local started code
  started=$(now_ms)
  podman stop --time 30 "$1" >/dev/null
  code=$(podman inspect --format '{{.State.ExitCode}}' "$1")
  echo "  $1 stopped after $(($(now_ms) - started)) ms, exit code $code"
  [ "$code" = 0 ] || wrong "$1" "it did not end in order"
  podman rm "$1" >/dev/null
}

as_shipped() {  # as_shipped NAME IMAGE: without a network, until its own health check is content
  hardened "$1" "$2" --detach --network none -- >/dev/null
  for _ in $(seq 120); do podman healthcheck run "$1" >/dev/null 2>&1 && break; sleep 0.5; done
  podman healthcheck run "$1" || wrong "$1" "it never became healthy"
  stop "$1"
}

wait_for() {  # wait_for NAME PORT: until it listens; leaves the milliseconds in `waited`
  local started
  started=$(now_ms)
  until "$python" -c "import socket; socket.create_connection(('127.0.0.1', $2), 1)" 2>/dev/null; do
    [ "$(podman inspect --format '{{.State.Running}}' "$1")" = true ] || wrong "$1" "it ended"
    [ $(($(now_ms) - started)) -lt 60000 ] || wrong "$1" "it does not listen"
  done
  waited=$(($(now_ms) - started))
}

# The host's network, because a bridge needs more than a sandbox has; so on loopback, and on a port that is free.
start_service() {
  port=$(free_port)
  hardened voa "$images" --detach --volume voa-data:/data --network host --env VOA_HOST=127.0.0.1 --env VOA_PORT="$port" \
    -- >/dev/null
  wait_for voa "$port"
  local ticks
  ticks=$(awk '{print $14 + $15}' "/proc/$(podman inspect --format '{{.State.Pid}}' voa)/stat")
  # The machine's other work does not count against it: what it did itself must fit.
  echo "  listening after $waited ms, of which it computed $((ticks * 1000 / $(getconf CLK_TCK)))"
  [ $((ticks * 1000 / $(getconf CLK_TCK))) -le "$most_start_ms" ] || fail "more than $most_start_ms ms"
}

check() { "$python" deploy/check_container.py "$1" "$2" "$work/session.json" || wrong "$3" "the container did not do its work"; }

use_service() {  # the main job, a fleet of customers, and the console
  check work "http://127.0.0.1:$port" voa
  hardened fleet "$images-fleet" --rm --network host -- --url "http://127.0.0.1:$port" --seed 1 ||
    wrong voa "the fleet did not get through its episode"
  local console
  console=$(free_port)
  hardened console "$images-console" --detach --network host -- --host 127.0.0.1 --port "$console" \
    --url "http://127.0.0.1:$port" >/dev/null
  wait_for console "$console"
  check page "http://127.0.0.1:$console" console
  stop console
  awk '/^Uid|^CapEff|^NoNewPrivs|^VmRSS|^VmHWM/ {$1 = $1; printf "  %s\n", $0}' \
    "/proc/$(podman inspect --format '{{.State.Pid}}' voa)/status"
}

[ -x "$python" ] || fail "there is no .venv: make setup"
[ "$(id -u)" -eq 0 ] || fail "without Docker this needs root (chroot, debootstrap): sudo make image. With Docker: docker build -f deploy/Dockerfile -t voa ."
need buildah podman runc
work=$(mktemp -d "${TMPDIR:-/var/tmp}/voa-image.XXXXXX")
trap clean EXIT

gather_wheels
choose_storage
choose_base
say "building"
build service "$images"
build fleet "$images-fleet"
build console "$images-console"
say "as they are shipped, without a network"
as_shipped voa "$images"
as_shipped console "$images-console"
say "the main job, with fleet and console"
start_service
use_service
stop voa
say "a new container on the same volume"
start_service
check recall "http://127.0.0.1:$port" voa
stop voa
if [ -n "${IMAGE_ARCHIVE:-}" ]; then
  podman save --quiet --multi-image-archive --output "$IMAGE_ARCHIVE" "$images" "$images-console" "$images-fleet"
  say "kept as $IMAGE_ARCHIVE"
fi
say "the images build, run hardened, and keep what they answered"
