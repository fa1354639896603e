#!/usr/bin/env bash
# Builds each fuzzer with clang's libFuzzer and both sanitizers, and runs it for some seconds on
# seeds: tests/fuzz/seeds, or the bundled scenes; as many at once as there are processors. A crash
# ends it with the offending input kept.
#   tests/fuzz/run.sh [SECONDS [ON]]     default 10; ON: every check of undefined behaviour
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-10} all_checks=${2:-OFF}
[[ "$seconds" =~ ^[0-9]+$ ]] || { echo "run.sh: SECONDS must be a whole number" >&2; exit 2; }
[[ "$all_checks" =~ ^(ON|OFF)$ ]] || { echo "run.sh: '$all_checks' is neither ON nor OFF" >&2; exit 2; }
build=build/fuzz
cmake -S . -B "$build" -G Ninja -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG="-O1 -g1" \
  -DSOFTSIM_WERROR=ON -DSOFTSIM_FUZZ=ON -DSOFTSIM_SANITIZE=address,undefined \
  -DSOFTSIM_SANITIZE_ALL="$all_checks" >/dev/null
cmake --build "$build" --target fuzzers
fuzz() {
  local name=$1
  local corpus="$build/corpus/$name"
  mkdir -p "$corpus"
  case "$name" in
    fuzz_scene)
      cp server/scenes/*.yaml "$corpus"/
      printf 'softsim: 1\nobject: {grid: {file: points.csv, rows: 2, columns: 2}, units: mm}\n%s\n' \
        'model: {name: jelly, modulus_j: 1, grain: [0, 1, 0]}' >"$corpus/grid.yaml"
      printf 'softsim: 1\nobject: {mesh: cube.msh, units: mm}\n%s\n' \
        'model: {name: jelly, modulus_j: 1, grain: {file: grain.csv}}' >"$corpus/grain.yaml"
      ;;
    fuzz_msh)
      printf '%s\n' '$MeshFormat' '2.2 0 8' '$EndMeshFormat' '$Nodes' 6 '1 0 0 0' '2 1 0 0' '3 2 0 0' \
        '4 0 1 0' '5 1 1 0' '6 2 1 0' '$EndNodes' '$Elements' 2 '1 3 2 1 0 1 2 5 4' \
        '2 3 2 0 0 2 3 6 5' '$EndElements' >"$corpus/quads.msh"
      ;;
    fuzz_lcmlog) head -c 20000 server/scenes/kidney-poke.lcmlog >"$corpus/poke" ;;
  esac
  [ ! -d "tests/fuzz/seeds/$name" ] || cp "tests/fuzz/seeds/$name"/* "$corpus"/
  local words=()
  [ ! -f "tests/fuzz/$name.dict" ] || words=("-dict=$PWD/tests/fuzz/$name.dict")
  (cd "$build" && "tests/$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -verbosity=0 \
    -print_final_stats=0 -artifact_prefix="crash_${name}_" "${words[@]}" "corpus/$name") \
    >"$build/$name.log" 2>&1 && echo "$name: clean after $seconds s" && return
  cat "$build/$name.log" >&2
  echo "run.sh: $name failed" >&2
  return 1
}
export -f fuzz
export build seconds
find "$build/tests" -maxdepth 1 -name 'fuzz_*' -executable -type f -printf '%f\n' | sort |
  xargs -P "$(nproc)" -I{} bash -euo pipefail -c 'fuzz {}'
echo "fuzz: clean"
