#!/usr/bin/env bash
# Installs what softsim needs on Debian 12. Does nothing when all of it is there.
#   tools/setup.sh [build] [test] [browser] [spy]     default: build
# browser: what the test of softsim-web's page in a headless browser needs, from npm too.
set -euo pipefail
build="build-essential cmake ninja-build pkg-config liblcm-dev liblcm-bin libglib2.0-dev libccd-dev
  libassimp-dev libfyaml-dev libsuitesparse-dev libcmocka-dev libnlopt-dev zlib1g-dev iproute2 gnuplot-nox libwebsockets-dev"
test="clang clang-format libclang-rt-14-dev shellcheck tetgen"
browser="chromium fonts-dejavu-core"
spy="liblcm-java libjchart2d-java default-jre default-jdk-headless"
wanted=""
for set in "${@:-build}"; do
  case "$set" in
    build) wanted="$wanted $build" ;;
    test) wanted="$wanted $build $test" ;;
    browser)
      wanted="$wanted $browser"
      command -v npm >/dev/null || wanted="$wanted nodejs npm"
      ;;
    spy) wanted="$wanted $spy" ;;
    --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "setup.sh: unknown set '$set'; use build, test, browser or spy" >&2; exit 2 ;;
  esac
done
missing=""
for package in $wanted; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep 'ok installed' >/dev/null || missing="$missing $package"
done
page_modules() {
  local page
  page=$(dirname "$0")/../clients/web/page
  [[ " $* " != *" browser "* ]] || [ -d "$page/node_modules/playwright-core" ] ||
    (cd "$page" && npm ci --ignore-scripts --no-audit --no-fund >/dev/null)
}
if [ -z "$missing" ]; then
  page_modules "$@"
  exit 0
fi
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
page_modules "$@"
