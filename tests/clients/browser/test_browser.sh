#!/usr/bin/env bash
# The page of softsim-web in a headless Chromium, against a real server: test_page.mjs has the claims.
# Skipped, and said so, where node, Chromium or playwright-core is not there: tools/setup.sh browser.
#   test_browser.sh SOURCE_DIR BIN_DIR [FOLDER]     FOLDER: where pictures are kept
set -euo pipefail
source_dir=$1 bin=$2
page=$source_dir/clients/web/page
for program in node chromium; do
  command -v $program >/dev/null || { echo "test_browser: no $program here: tools/setup.sh browser"; exit 77; }
done
[ -d "$page/node_modules/playwright-core" ] || { echo "test_browser: no playwright-core here: tools/setup.sh browser"; exit 77; }
if [ -z "${SOFTSIM_BROWSER_INSIDE:-}" ]; then
  flags=-n; [ "$(id -u)" = 0 ] || flags=-rn
  unshare $flags true 2>/dev/null || { echo "test_browser: no private network here"; exit 77; }
  SOFTSIM_BROWSER_INSIDE=1 exec unshare $flags bash -c \
    'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' test "$0" "$@"
fi
work=$(mktemp -d)
pids=()
finish() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap finish EXIT
mkdir "$work/records"
start() { # name, what it says when it is there, program...
  local name=$1 said=$2
  shift 2
  : >"$work/$name"
  "$@" >"$work/$name" 2>&1 &
  pids+=("$!")
  until grep -q "$said" "$work/$name"; do
    kill -0 "${pids[-1]}" 2>/dev/null || { cat "$work/$name" >&2; exit 1; }
    sleep 0.05
  done
}
start server '^softsimd: ready' "$bin/softsimd" "$source_dir/server/scenes/kidney.yaml"
start web 'in a browser' "$bin/softsim-web" --port 0 --record-dir "$work/records"
address=$(sed -n 's/.*open \(http:[^ ]*\) in a browser.*/\1/p' "$work/web")
NODE_PATH=$page/node_modules node "$(dirname "$0")/test_page.mjs" "$page" "$address" "${3:-$work}" ||
  { cat "$work/server" "$work/web" >&2; exit 1; }

# What was recorded plays, and twice the same.
log=$(find "$work/records" -name '*.lcmlog')
for run in 1 2; do
  "$bin/softsim-run" "$source_dir/server/scenes/kidney.yaml" --poses "$log" --hash 2>/dev/null | tail -1 >"$work/hash$run"
done
cmp "$work/hash1" "$work/hash2"
[ -s "$work/hash1" ]
echo "test_browser: the recording plays twice to $(cat "$work/hash1")"
