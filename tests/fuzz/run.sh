#!/usr/bin/env bash
# Builds each fuzzer with clang's libFuzzer and both sanitizers, and runs it for some seconds on
# seeds: tests/fuzz/seeds, or the bundled scenes. A crash ends it with the offending input kept.
#   tests/fuzz/run.sh [SECONDS]     default 10
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-10}
[[ "$seconds" =~ ^[0-9]+$ ]] || { echo "run.sh: SECONDS must be a whole number" >&2; exit 2; }
build=build/fuzz
cmake -S . -B "$build" -G Ninja -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG="-O1 -g" \
  -DSOFTSIM_FUZZ=ON -DSOFTSIM_SANITIZE=address,undefined >/dev/null
cmake --build "$build" --target fuzzers
for program in "$build"/tests/fuzz_*; do
  [ -x "$program" ] || continue
  name=$(basename "$program")
  corpus="$build/corpus/$name"
  mkdir -p "$corpus"
  case "$name" in
    fuzz_scene) cp server/scenes/*.yaml "$corpus"/ ;;
    fuzz_lcmlog) head -c 20000 server/scenes/kidney-poke.lcmlog >"$corpus/poke" ;;
  esac
  [ ! -d "tests/fuzz/seeds/$name" ] || cp "tests/fuzz/seeds/$name"/* "$corpus"/
  words=()
  [ ! -f "tests/fuzz/$name.dict" ] || words=("-dict=$PWD/tests/fuzz/$name.dict")
  echo "== $name, $seconds s"
  (cd "$build" && "tests/$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -verbosity=0 \
    -print_final_stats=0 -artifact_prefix="crash_${name}_" "${words[@]}" "corpus/$name")
done
echo "fuzz: clean"
