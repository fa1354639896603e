#!/usr/bin/env bash
# Builds each model alone, without convex tools, and tests it: its own tests pass, its programs hold
# nothing of any other model, a scene with another model or a convex tool is refused by name. Prints
# a table: bytes of softsim-run and softsimd without their symbols, and the libraries they load.
#   tools/single_models.sh [MODEL...]      without one: two, others every day; "all": every one
set -euo pipefail
cd "$(dirname "$0")/.."
folder=build/single
mapfile -t known < <(sed -nE 's/^ss_model\(([a-z-]+) .*/\1/p' server/models/*/CMakeLists.txt)
models=("$@")
case "${1:-}" in
  --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
  all) models=("${known[@]}") ;;
  "") day=$(($(date +%s) / 86400)) count=${#known[@]}
    models=("${known[day * 2 % count]}" "${known[(day * 2 + 1) % count]}") ;;
esac
for model in "${models[@]}"; do
  if [[ " ${known[*]} " != *" $model "* ]]; then
    echo "single_models.sh: '$model' is no model; there are ${known[*]}, or all" >&2
    exit 2
  fi
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "single_models.sh: $1" >&2; exit 1; }

# The names of functions and constants at file level, static ones too.
names() {
  sed -nE 's/^[a-z][A-Za-z0-9_ *]*[ *]([a-z][a-z0-9_]*)(\(| = |\[).*/\1/p; s/^SS_MODEL_CLASS\(([a-z_]+),.*/\1/p' "$@" | sort -u
}

# Symbols of $1 that stand in sources of models which this build leaves out, and in no other source.
foreign() {
  grep -oE 'server/models/[a-z_]+/[a-z0-9_]+\.c' $folder/build.ninja | sort -u >"$work/built"
  find server/models/*/ -name '*.c' | sort -u | comm -13 "$work/built" - >"$work/left_out"
  mapfile -t left_out <"$work/left_out"
  find server -name '*.[ch]' | grep -vxFf "$work/left_out" >"$work/others"
  mapfile -t others <"$work/others"
  names "${others[@]}" >"$work/ours"
  names "${left_out[@]}" | comm -23 - "$work/ours" >"$work/theirs"
  [ -s "$work/theirs" ] || fail "no names of other models found"
  nm "$1" | sed -E 's/^.* [a-zA-Z] //; /\.[0-9]+$/{/\.[a-z]+\.[0-9]+$/!d}; s/\..*//' | sort -u >"$work/symbols"
  comm -12 "$work/symbols" "$work/ours" | grep '^ss_model_' >/dev/null || fail "$1 has no symbols to look at"
  comm -12 "$work/symbols" "$work/theirs"
}

bytes() { strip -o "$work/stripped" "$1" && stat -c %s "$work/stripped"; }

# refuses REASON SCENE: exit 2, and the reason in the text.
refuses() {
  local said status=0 reason=$1
  shift
  said=$($folder/bin/softsimd --check "$@" 2>&1) || status=$?
  if [ $status != 2 ] || [[ "$said" != *"$reason"* ]]; then
    fail "softsimd --check $*: status $status, not 2 with '$reason': $said"
  fi
}

printf 'softsim: 1\nobject: {mesh: %s, units: mm}\nmodel: {name: NAME}\n' \
  "$PWD/server/scenes/kidney.obj" >"$work/scene"
printf 'contact: {tools: [{probe: 0, shape: {convex: {file: %s, units: mm}}}]}\n' \
  "$PWD/server/scenes/kidney.obj" >>"$work/scene"
for model in "${models[@]}"; do
  cmake -S . -B $folder -G Ninja -DCMAKE_BUILD_TYPE=Release -DSOFTSIM_WERROR=ON -DSOFTSIM_CONVEX=OFF \
    -DSOFTSIM_MODELS="$model" -DSOFTSIM_{WEB,REPLAY,BRIDGE,MONITOR,BENCH,FIT}=OFF >/dev/null
  cmake --build $folder --target models >"$work/log" || { cat "$work/log"; exit 1; }
  ctest --test-dir $folder -L models --no-tests=error --output-on-failure >"$work/log" </dev/null ||
    { cat "$work/log"; exit 1; }
  tests=$(sed -nE 's/^100% tests passed.* out of ([0-9]+).*/\1/p' "$work/log")
  for program in softsim-run softsimd; do
    foreign $folder/bin/$program >"$work/foreign"
    [ ! -s "$work/foreign" ] || fail "$model alone: $program has symbols of other models: $(head -5 "$work/foreign" | tr '\n' ' ')"
  done
  other=${known[0]}
  [ "$other" != "$model" ] || other=${known[1]}
  sed "s/NAME/$other/" "$work/scene" >"$work/other.yaml"
  sed "s/NAME/$model/" "$work/scene" >"$work/convex.yaml"
  refuses "built in: $model" "$work/other.yaml"
  refuses -DSOFTSIM_CONVEX=ON "$work/convex.yaml"
  libraries=$(readelf -d $folder/bin/softsimd | sed -nE 's/.*NEEDED.*\[lib([^.]*)\.so.*/\1/p' | grep -vx c | tr '\n' ' ')
  printf '%-13s  softsim-run %s B, softsimd %s B, 0 symbols of other models, %s tests; loads %s\n' \
    "$model" "$(bytes $folder/bin/softsim-run)" "$(bytes $folder/bin/softsimd)" "$tests" "$libraries"
done
