#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# How many haptic periods a flood makes late on one processor that server, client and flooder share:
# a quiet window and one under flood in turn, for every kind. Not a test: the figures are the
# machine's. Inside a private network namespace.
#   flood_report.sh BIN SCENE [SECONDS [RATE [KIND...]]]     default 3 s, as fast as it goes, all
set -uo pipefail
bin=$1
scene=$2
seconds=${3:-3}
rate=${4:-0}
shift 4
if [ -z "${INSIDE:-}" ]; then
  # shellcheck disable=SC2016
  INSIDE=1 exec unshare -n bash -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' \
    report taskset -c "${CORE:-0}" "$0" "$bin" "$scene" "$seconds" "$rate" "$@"
fi
unset LCM_DEFAULT_URL
folder=$(mktemp -d)
"$bin/softsimd" "$scene" --log-level error >"$folder/out" 2>"$folder/err" &
server=$!
trap 'kill $server $bridge 2>/dev/null; rm -rf "$folder"' EXIT
until grep -q ready "$folder/out"; do sleep 0.1; done
"$bin/softsim-bridge" --device sim >/dev/null 2>"$folder/bridge" &
bridge=$!
sleep 2
# Prints probe 0's periods, forces, missed.
count() {
  "$bin/softsim-monitor" --once --json | tr -d '\n' |
    sed -E 's/.*"probe_periods": \[([0-9]+).*"probe_missed": \[([0-9]+).*/\1 \2/'
}
share() { awk -v a="$1" -v b="$2" 'BEGIN {split(a, x, " "); split(b, y, " "); n = y[1] - x[1];
  printf "%.3f", (n > 0 ? 100 * (y[2] - x[2]) / n : 100)}'; }
echo "kind,packets_per_s,quiet_missed_percent,flood_missed_percent"
for kind in "${@:-$("$bin/flood" --list | grep -v shutdown)}"; do
  for k in $kind; do
    before=$(count)
    sleep "$seconds"
    between=$(count)
    said=$(taskset -c "${FLOOD_CORE:-${CORE:-0}}" "$bin/flood" "$k" --rate "$rate" --seconds "$seconds")
    after=$(count)
    echo "$k,$(sed -E 's/.*, ([0-9]+) a second/\1/' <<<"$said"),$(share "$before" "$between"),$(share "$between" "$after")"
    [ "$k" != command-pause ] || "$bin/softsim-monitor" --command resume >/dev/null
  done
done
kill -0 "$bridge" 2>/dev/null || cat "$folder/bridge" >&2
