#!/usr/bin/env bash
# The tests, all of them: sets up a fresh Debian 12, builds and runs the suite in release, with
# address and undefined-behaviour sanitizers, with the thread sanitizer (what has threads), and in
# double precision (what computes); builds two of the models alone; checks all sources with clang's
# warnings; runs each fuzzer for a few seconds; checks layers and layout.
#   tools/test.sh [--quick | --long]
#     --quick: release only
#     --long:  every test in every build at its full size, which release runs already but for the
#              longest, and under every check of undefined behaviour; every model alone; all of it
#              built with clang too, and a minute for each fuzzer
set -euo pipefail
cd "$(dirname "$0")/.."
quick="" long="" fuzz_s=2 all_checks=OFF
if [ $# -gt 1 ]; then
  echo "test.sh: '$2' is one argument too many; use --quick or --long" >&2
  exit 2
fi
case "${1:-}" in
  "") ;;
  --quick) quick=1 ;;
  --long) long=1 fuzz_s=60 all_checks=ON SOFTSIM_TESTS_LONG=1; export SOFTSIM_TESTS_LONG ;; # read by tests/common/effort.h
  --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) echo "test.sh: unknown argument '$1'; use --quick or --long" >&2; exit 2 ;;
esac
sets=(build)
[ -n "$quick" ] || sets+=(test)
tools/setup.sh "${sets[@]}"
tools/own_builds.sh
started=$SECONDS
jobs=$(($(nproc) + 2)) # process tests mostly wait
say() { printf '\n== %s (%d s)\n' "$1" $((SECONDS - started)); }

build_and_test() { # preset, target, ctest arguments
  local preset=$1 target=$2; shift 2
  say "$preset: build"
  cmake --preset "$preset" -DSOFTSIM_SANITIZE_ALL=$all_checks >/dev/null
  cmake --build --preset "$preset" --target "$target"
  say "$preset: test"
  ctest --preset "$preset" -j "$jobs" "$@" </dev/null
}

# The sources of every program and test, their warnings only: what is compiled to run is gcc's, and
# the fuzzers'. After the fuzzers, whose build has made the headers and gone through their own sources.
check_with_clang() {
  (cd build/fuzz && ninja -t commands all | grep -vxFf <(ninja -t commands fuzzers) |
    sed -n 's/ -MD -MT [^ ]* -MF [^ ]* -o [^ ]* -c \([^ ]*\.c\)$/ -fsyntax-only \1/p' |
    xargs -d '\n' -P "$(nproc)" -I{} sh -c '{}')
}

tools/check_layers
build_and_test release all
[ -z "$quick" ] || exit 0
tools/check_style
build_and_test dev all
build_and_test tsan threads -L threads
if [ -n "$long" ]; then build_and_test scalar all; else build_and_test scalar numbers -L numbers; fi
say "single models"
tools/single_models.sh ${long:+all}
say "fuzz"
tests/fuzz/run.sh $fuzz_s $all_checks
say "clang: warnings"
check_with_clang
[ -z "$long" ] || cmake --build build/fuzz
say "all done"
