#!/usr/bin/env bash
# The page of softsim-web in a headless Chromium, against a real server: test_page.mjs and
# test_session.mjs have the claims.
# Skipped, and said so, where node, Chromium or playwright-core is not there: tools/setup.sh browser.
#   test_browser.sh SOURCE_DIR BIN_DIR [FOLDER]     FOLDER: where pictures are kept
set -euo pipefail
source_dir=$1 bin=$2
work="" address="" # set by the next
# shellcheck source=tests/clients/browser/stage.sh
. "$(dirname "$0")/stage.sh"
page=$source_dir/clients/web/page
need_browser "$page"
enter_network "$@"
open_stage
node "$(dirname "$0")/test_parts.mjs" "$page"
node "$(dirname "$0")/test_session.mjs" "$page" "$bin" "$source_dir/server/scenes" "$work" "${3:-$work}"
mkdir "$work/records"
start server '^softsimd: ready' "$bin/softsimd" "$source_dir/server/scenes/kidney.yaml"
start_web "$bin" --record-dir "$work/records"
NODE_PATH=$page/node_modules node "$(dirname "$0")/test_page.mjs" "$page" "$address" "${3:-$work}" ||
  { cat "$work/server" "$work/web" >&2; exit 1; }

# What was recorded plays; in lockstep twice the same, bit for bit.
log=$(find "$work/records" -name '*.lcmlog')
end_all
replay() { # name, options of softsimd
  local name=$1 options=("${@:2}")
  start "server-$name" '^softsimd: ready' "$bin/softsimd" "$source_dir/server/scenes/kidney.yaml" "${options[@]}"
  "$bin/softsim-replay" ${options[0]:+--lockstep} --csv "$work/$name.csv" "$log" >"$work/$name" 2>&1 || { cat "$work/$name" >&2; exit 1; }
  end_all
}
replay first --lockstep --hash
replay second --lockstep --hash
replay realtime
for run in first second; do
  cut -d, -f1,3-13,15- "$work/$run.csv" >"$work/$run.forces" # without the clock's columns
  tail -1 "$work/server-$run" >"$work/$run.hash"
done
cmp "$work/first.forces" "$work/second.forces"
cmp "$work/first.hash" "$work/second.hash"
grep -q '^[0-9a-f]\{16\}$' "$work/first.hash"
echo "test_browser: the recording plays twice in lockstep to $(cat "$work/first.hash"), $(wc -l <"$work/first.forces") equal lines"
for run in first realtime; do
  echo "test_browser: $run: $(node "$(dirname "$0")/compare_forces.mjs" "$log" "$work/$run.csv" 0)"
done
