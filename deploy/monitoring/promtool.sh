#!/bin/sh
# Runs promtool: the installed one, or that of Debian's package, which is unpacked into build/ without being installed.
set -eu
cd "$(dirname "$0")"
unpacked=../../build/promtool
if command -v promtool >/dev/null; then
  exec promtool "$@"
fi
if [ ! -x "$unpacked/usr/bin/promtool" ]; then
  command -v apt-get >/dev/null || { echo "promtool is not installed: install Prometheus, which has it" >&2; exit 1; }
  rm -rf "$unpacked" && mkdir -p "$unpacked"
  (cd "$unpacked" && apt-get -qq download prometheus && dpkg -x prometheus_*.deb .) || {
    echo "promtool cannot be fetched: apt-get update, or install Prometheus, which has it" >&2
    exit 1
  }
fi
exec "$unpacked/usr/bin/promtool" "$@"
