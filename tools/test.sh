#!/usr/bin/env bash
# The tests, all of them: sets up a fresh Debian 12, builds and runs the suite in release, with
# address and undefined-behaviour sanitizers, with the thread sanitizer (what has threads; the rest
# by ctest --preset tsan), and in double precision; compiles with clang; runs each fuzzer for a few
# seconds; checks the layers.
#   tools/test.sh [--quick]     --quick: release only
set -euo pipefail
cd "$(dirname "$0")/.."
quick=""
if [ $# -gt 1 ]; then
  echo "test.sh: '$2' is one argument too many; use --quick" >&2
  exit 2
fi
case "${1:-}" in
  "") ;;
  --quick) quick=1 ;;
  --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) echo "test.sh: unknown argument '$1'; use --quick" >&2; exit 2 ;;
esac
tools/setup.sh build ${quick:+} $([ -n "$quick" ] || echo test)
started=$SECONDS
jobs=$(($(nproc) + 2)) # process tests mostly wait
say() { printf '\n== %s (%d s)\n' "$1" $((SECONDS - started)); }

build_and_test() { # preset, target, ctest arguments
  local preset=$1 target=$2; shift 2
  say "$preset: build"
  cmake --preset "$preset" >/dev/null
  cmake --build --preset "$preset" --target "$target"
  say "$preset: test"
  ctest --preset "$preset" -j "$jobs" --timeout 300 "$@"
}

tools/check_layers
build_and_test release all
[ -z "$quick" ] || exit 0
build_and_test dev all
build_and_test tsan threads -L threads
build_and_test scalar all -LE 'process|mesh'

say "clang: build"
cmake -S . -B build/clang -G Ninja -DCMAKE_C_COMPILER=clang -DSOFTSIM_WERROR=ON \
  -DCMAKE_BUILD_TYPE=Debug >/dev/null
cmake --build build/clang

say "fuzz"
tests/fuzz/run.sh 5
say "all done"
