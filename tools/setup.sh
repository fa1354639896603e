#!/usr/bin/env bash
# Installs what softsim needs on Debian 12. Does nothing when all of it is there.
#   tools/setup.sh [build] [test] [spy]     default: build
set -euo pipefail
build="build-essential cmake ninja-build pkg-config liblcm-dev liblcm-bin libglib2.0-dev libccd-dev
  libassimp-dev libfyaml-dev libsuitesparse-dev libcmocka-dev libnlopt-dev zlib1g-dev iproute2 gnuplot-nox"
test="clang clang-format libclang-rt-14-dev shellcheck tetgen"
spy="liblcm-java libjchart2d-java default-jre default-jdk-headless"
wanted=""
for set in "${@:-build}"; do
  case "$set" in
    build) wanted="$wanted $build" ;;
    test) wanted="$wanted $build $test" ;;
    spy) wanted="$wanted $spy" ;;
    --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "setup.sh: unknown set '$set'; use build, test or spy" >&2; exit 2 ;;
  esac
done
missing=""
for package in $wanted; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep 'ok installed' >/dev/null || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
echo "setup.sh: installing$missing" >&2
as_root=""
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "setup.sh: run as root, or install sudo:$missing" >&2; exit 1; }
  as_root=sudo
fi
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
# shellcheck disable=SC2086
{ $as_root apt-get update -qq && $as_root apt-get install -y -qq --no-install-recommends $missing; } >"$log" 2>&1 || {
  cat "$log" >&2
  echo "setup.sh: installing failed; the packages are:$missing" >&2
  exit 1
}
rm -f "$log"
