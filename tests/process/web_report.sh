#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# What softsim-web costs: a kidney of 5762 nodes at 60 Hz under a sliding tool, with no viewer, with
# softsim-web and 0, 1 and 5 browsers that draw nothing, with one more that never reads, at rest, and
# last, where Chromium is (tools/setup.sh browser), with one that draws in software. Not a test: the
# figures are the machine's. Inside a private network namespace; some four minutes.
#   web_report.sh BIN SOURCE_DIR [SECONDS [ROUNDS]]     12 s a row, 2 rounds of all rows
# Of one browser: kB a second, frames of the body a second (the fewest of any; of the one that draws,
# those drawn). CPU in % of one core. Lateness of the haptic loop in us (p50, p99, p99.9 of the last
# 10 s), and how many of the tool's forces were missed in the row.
set -euo pipefail
bin=$1 source_dir=$2 seconds=${3:-12} rounds=${4:-2}
work="" address="" # set by the next
# shellcheck source=tests/clients/browser/stage.sh
. "$source_dir/tests/clients/browser/stage.sh"
enter_network "$@"
open_stage
"$bin/softsim-mesh" generate kidney --points 5762 --out "$work/kidney.obj" >/dev/null 2>&1
cat >"$work/kidney.yaml" <<'SCENE' # a model that this mesh does not keep busy
softsim: 1
object:
  mesh: kidney.obj
  units: mm
  fixed: [{sphere: {center_m: [0, -0.017, 0], radius_m: 0.015}}]
model: {name: cnn-chainmail, link_stiffness_n_per_m: 60}
contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}], working_force_n: 2}
simulation: {rate_hz: 250}
publish: {mesh_rate_hz: 60}
SCENE
start server '^softsimd: ready' "$bin/softsimd" "$work/kidney.yaml"
daemon=${pids[0]}
hertz=$(getconf CLK_TCK)

ticks() { awk '{ sub(/.*\) /, ""); print $12 + $13 }' "/proc/$1/stat"; } # of a process
state() { "$bin/softsim-monitor" --once --json; }
missed() { state | sed 's/.*"probe_missed": *\[\([0-9]*\).*/\1/'; }
browse() { # until it says how many frames it drew
  node "$source_dir/tests/clients/browser/watch.mjs" "$source_dir/clients/web/page" "$address" "$seconds"
}
# name, is there a viewer, what to wait for (its output: "counting", then kB frames fewest)
row() {
  local name=$1 web=$2
  shift 2
  local before_d after_d before_w=0 after_w=0 miss
  : >"$work/reader"
  "$@" >"$work/reader" &
  local reader=$!
  until grep -q counting "$work/reader"; do
    kill -0 $reader 2>/dev/null || { echo "web_report.sh: $name: nothing is read" >&2; exit 1; }
    sleep 0.1
  done
  miss=$(missed) before_d=$(ticks "$daemon")
  [ -z "$web" ] || before_w=$(ticks "$web")
  wait $reader
  after_d=$(ticks "$daemon")
  [ -z "$web" ] || after_w=$(ticks "$web")
  state >"$work/state"
  miss=$(($(missed) - miss))
  sed 's/.*"lateness_us": *\[\([^]]*\)\].*/\1/' "$work/state" | tr -d ' ' | tr , ' ' >"$work/late"
  awk -v name="$name" -v s="$seconds" -v hz="$hertz" -v d=$((after_d - before_d)) -v w=$((after_w - before_w)) -v miss="$miss" '
    FILENAME ~ /reader$/ && NF == 3 { kb = $1 / 1e3; least = $3 }
    FILENAME ~ /late$/ { late = sprintf("%4.0f %5.0f %6.0f", $1, $2, $3) }
    END { printf "%-38s %7.1f %6.1f %7.1f %5.1f   %s %7d\n", name, kb, least, 100 * d / hz / s, 100 * w / hz / s, late, miss }
  ' "$work/reader" "$work/late"
}
nobody() { echo counting; sleep "$seconds"; echo "0 0 0"; }
read_on() { # browsers, sleepers
  local port=${address##*:}
  "$bin/../tests/web_reader" "${port%/}" "$seconds" "$@"
}

printf '%-38s %7s %6s %7s %5s   %s\n' '' kB/s frame/s daemon web 'late p50   p99  p99.9  missed'
for round in $(seq "$rounds"); do
  "$bin/softsim-bridge" --device sim --script slide --offset-m 0,0.006,0.0273 >"$work/bridge" 2>&1 &
  bridge=$!
  pids+=("$bridge")
  sleep 3
  row "$round: tool slides, no softsim-web" "" nobody
  start_web "$bin"
  web=${pids[-1]}
  row "$round: softsim-web, nobody looks" "$web" nobody
  row "$round: 1 browser" "$web" read_on 1 0
  row "$round: 5 browsers" "$web" read_on 5 0
  row "$round: 5 browsers, 1 that never reads" "$web" read_on 5 1
  if command -v chromium >/dev/null && [ -d "$source_dir/clients/web/page/node_modules/playwright-core" ]; then
    row "$round: 1 that draws in software" "$web" browse
  fi
  kill "$bridge"
  wait "$bridge" 2>/dev/null || true
  "$bin/softsim-monitor" --command reset >/dev/null
  row "$round: at rest, 1 browser" "$web" read_on 1 0
  kill "$web"
  wait "$web" 2>/dev/null || true
  address=""
done
