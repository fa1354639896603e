#!/usr/bin/env bash
# Plants one defect at a time in a scratch copy of the sources, builds it, and shows who catches it:
# its unit tests; softsim-bench stability, whose verdicts must disagree with what its
# audit finds (or a control run must no longer be good); and softsim-bench accuracy on the smallest
# slab, whose rows (error of the field in two digits, verdict) must change where the defect touches
# statics. The last two are a force that doubles on the way out, and a watch that takes mJ for J.
# A defect that the first or the second misses ends it with status 1.
#   tests/planted_defects.sh [--check] [SCRATCH]     default build/planted
# --check only sees to it that every defect can still be planted: its line is there once.
set -euo pipefail
cd "$(dirname "$0")/.."
is_check=no
if [ "${1:-}" = --check ]; then
  is_check=yes
  shift
fi
scratch=${1:-build/planted}

# model | unit test | file | line as it is | line with the defect
defects=(
  'cnn-energy|test_cnn_step|server/models/cnn/kernels.c|f = ss_pair_fnma(ss_pair_each(s->rest_stiffness + i), ss_pair_load(s->d + at), f);|f = ss_pair_fma(ss_pair_each(s->rest_stiffness + i), ss_pair_load(s->d + at), f);'
  'cnn-energy|test_cnn_step|server/models/cnn/kernels.c|ss_pair f = ss_pair_sub(ss_pair_load(s->force + at), gamma_v);|ss_pair f = ss_pair_add(ss_pair_load(s->force + at), gamma_v);'
  'fem|test_fem|server/models/common/fem_kernels.c|p.m[k / 3][k % 3] = all(0.0) - p.m[k / 3][k % 3];|p.m[k / 3][k % 3] = all(0.0) + p.m[k / 3][k % 3];'
  'mass-spring|test_mass_spring|server/models/mass_spring/mass_spring.c|f[e->from + a] += pull * now.n[a];|f[e->from + a] -= pull * now.n[a];'
  'mass-spring|test_body|server/models/common/body_step.c|book_load(body, ss_body_loads_work(body));|book_load(body, -ss_body_loads_work(body));'
  'fem|test_abuse|server/haptic/haptic.c|ss_scale3(out_sent, whole, gain);|ss_scale3(out_sent, whole, ss_dot3(haptic->v, whole) > 0.0 ? 2.0 : 1.0);'
  'fem|test_watch|server/world/watch.c|most_handed_out = 0.01;|most_handed_out = 10.0;'
)

# The line of file $1 that has $2 must be the only one.
find_line() {
  local count
  count=$(grep -cF -- "$2" "$1" || true)
  [ "$count" = 1 ] || { echo "planted_defects.sh: $1: $count places like '$2', not one" >&2; exit 1; }
}

# Puts $3 in the place of $2 in file $1.
plant() {
  find_line "$1" "$2"
  OLD=$2 NEW=$3 awk '{
    at = index($0, ENVIRON["OLD"])
    if (at > 0) {
      $0 = substr($0, 1, at - 1) ENVIRON["NEW"] substr($0, at + length(ENVIRON["OLD"]))
    }
    print
  }' "$1" >"$1.planted"
  mv "$1.planted" "$1"
}

if [ "$is_check" = yes ]; then
  for defect in "${defects[@]}"; do
    IFS='|' read -r model test file old new <<<"$defect"
    find_line "$file" "$old"
    [ -n "$(find tests -name "$test.c")" ] || { echo "planted_defects.sh: no $test.c in tests" >&2; exit 1; }
  done
  echo "planted_defects.sh: ${#defects[@]} defects can be planted"
  exit 0
fi

mkdir -p "$scratch"
source=$scratch/source
build=$scratch/build
rm -rf "$source"
mkdir -p "$source"
cp -r CMakeLists.txt include lcmtypes server clients tools tests "$source"/
cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release >/dev/null

# Failures of the stability report of model $1; a run that fails altogether counts as one.
failures() {
  local out=$scratch/report status=0
  rm -rf "$out"
  "$build/bin/softsim-bench" stability --quick --model "$1" --out "$out" >"$scratch/log" || status=$?
  if [ "$status" -gt 1 ]; then
    echo 1
  else
    grep -c '^FAIL' "$scratch/log" || true
  fi
}

# Rows of model $1 on the slab: level, field error, verdict.
errors() {
  local out=$scratch/accuracy
  rm -rf "$out"
  "$build/bin/softsim-bench" accuracy --quick --case tests/reference/c_slab --mesh 300 --model "$1" \
    --out "$out" >"$scratch/log" 2>&1 || true
  awk -F, 'NR > 1 { printf "%s %s %.2f %s\n", $2, $7, $8, $17 }' "$out/accuracy.csv" 2>"$scratch/log" || true
}

status=0
for defect in "${defects[@]}"; do
  IFS='|' read -r model test file old new <<<"$defect"
  cmake --build "$build" --target softsim-bench "$test" >/dev/null
  before=$(failures "$model")
  right=$(errors "$model")
  (cd "$build" && "./tests/$test" >/dev/null 2>&1) || { echo "$test fails without a defect" >&2; status=1; }
  cp "$source/$file" "$scratch/kept"
  plant "$source/$file" "$old" "$new"
  cmake --build "$build" --target softsim-bench "$test" >/dev/null
  after=$(failures "$model")
  wrong=$(errors "$model")
  by_test=no
  (cd "$build" && "./tests/$test" >/dev/null 2>&1) || by_test=yes
  cp "$scratch/kept" "$source/$file"
  by_report=no
  [ "$after" -gt "$before" ] && by_report=yes
  echo "$model, $file: $new"
  by_accuracy=no
  [ "$right" != "$wrong" ] && by_accuracy=yes
  echo "  accuracy: $by_accuracy; stability: $by_report ($before failures before, $after after); $test: $by_test"
  [ "$by_report" = yes ] && [ "$by_test" = yes ] || status=1
done
exit $status
