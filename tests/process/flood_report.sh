#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# How many haptic periods a flood makes late on one processor that server, client and flooder share.
# Not a test: the figures are the machine's. Inside a private network namespace.
#   flood_report.sh BIN SCENE [ROUNDS [SECONDS [RATE [KIND...]]]]   9 rounds of 1.5 s, as fast as
#                                                                  it goes, all kinds: 17 min
#   CORE: the processor (0). WINDOWS: a file for the figures of every window.
#
# Neighbours take time as they like, so that a window by itself says little. Quiet and flooded
# windows take turns, kinds in a new order every round, and a flooded window is compared with the
# quiet ones before and behind it: d = flood - (2 quiet + 0.1), all in % of periods missed. A kind
# exceeds the bound when the 95 % interval of the median of d (order statistics, no distribution
# assumed) lies above 0, keeps it when it lies at or below 0, and is open when it holds both; `p` is
# the sign test's, one-sided: how likely so many d above 0 are when half of them are. With so many
# kinds one or two p below 0.05 are chance. The last lines judge quiet windows as if they were
# flooded, which tells what the machine does by itself.
#
# Windows are cut from the statuses inside them by the server's own times, or around them where a
# flood left less than two; the monitor that hears them may run on any processor, and starts again
# after a flood of statuses, which it would hold to. `others` is the share of the processor that
# neither server, client, flooder nor idling took, `steal` what the host took: neighbours either way.
set -uo pipefail
bin=$1
scene=$2
rounds=${3:-9}
seconds=${4:-1.5}
rate=${5:-0}
shift $(($# < 5 ? $# : 5))
core=${CORE:-0}
if [ -z "${INSIDE:-}" ]; then
  # shellcheck disable=SC2016
  INSIDE=1 exec unshare -n bash -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' \
    report "$0" "$bin" "$scene" "$rounds" "$seconds" "$rate" "$@"
fi
unset LCM_DEFAULT_URL
folder=$(mktemp -d)
log=$folder/statuses
windows=${WINDOWS:-$folder/windows}
listen() {
  "$bin/softsim-monitor" --json >>"$log" 2>/dev/null &
  monitor=$!
}
listen
taskset -c "$core" "$bin/softsimd" "$scene" --log-level error >"$folder/out" 2>"$folder/err" &
server=$!
trap 'kill $server $bridge $monitor 2>/dev/null; rm -rf "$folder"' EXIT
until grep -q ready "$folder/out"; do sleep 0.1; done
taskset -c "$core" "$bin/softsim-bridge" --device sim --offset-m 0,0,0 >/dev/null 2>"$folder/bridge" &
bridge=$!
sleep 2

# us of the clock that stamps statuses, then ticks of the processor: in all, idle, steal; of ours.
look() {
  awk -v core="cpu$core" -v pids="$server $bridge" 'BEGIN {
    getline uptime <"/proc/uptime"; split(uptime, up, " ")
    while ((getline line <"/proc/stat") > 0) {
      split(line, c, " ")
      if (c[1] == core) { for (i = 2; i <= 9; ++i) all += c[i]; idle = c[5] + c[6]; steal = c[9] }
    }
    n = split(pids, pid, " ")
    for (i = 1; i <= n; ++i) {
      getline line <("/proc/" pid[i] "/stat"); sub(/.*\) /, "", line); split(line, f, " ")
      ours += f[12] + f[13]
    }
    printf "%.0f %d %d %d %d", 1e6 * up[1], all, idle, steal, ours }'
}

# One line a window: kind, its bounds, ticks, packets a second.
note() { echo "$1 $2 $3 $4" >>"$folder/marks"; }
quiet() {
  local before
  before=$(look)
  sleep "$seconds"
  note quiet "$before" "$(look)" "0 0"
}
flood() {
  local before after said
  TIMEFORMAT='%U %S'
  before=$(look)
  { time said=$(taskset -c "$core" "$bin/flood" "$1" --rate "$rate" --seconds "$seconds"); } \
    2>"$folder/time"
  after=$(look)
  note "$1" "$before" "$after" \
    "$(sed -E 's/.*, ([0-9]+) a second/\1/' <<<"$said") $(awk '{print 100 * ($1 + $2)}' "$folder/time")"
  case $1 in
  command-pause) until "$bin/softsim-monitor" --command resume >/dev/null 2>&1; do :; done ;;
  status*)
    kill "$monitor" && wait "$monitor"
    listen
    ;;
  esac
}

kinds=("$@")
[ $# -gt 0 ] || mapfile -t kinds < <("$bin/flood" --list | grep -v shutdown)
quiet
for ((round = 0; round < rounds; ++round)); do
  for kind in $(shuf -e "${kinds[@]}"); do
    flood "$kind"
    quiet
  done
done
kill -0 "$bridge" 2>/dev/null || cat "$folder/bridge" >&2
kill "$monitor" && wait "$monitor"

# Every status: its time, and probe 0's periods and missed.
sed -nE '/"scene": "flood"/d; s/^\{"utime": ([0-9]+).*"probe_periods": \[([0-9]+).*"probe_missed": \[([0-9]+).*/\1 \2 \3/p' \
  "$log" >"$folder/counts"
# shellcheck disable=SC2016
awk 'NR == FNR { t[NR] = $1; periods[NR] = $2; missed[NR] = $3; count = NR; next }
  { while (at < count && t[at + 1] < $2) ++at
    first = at + 1
    for (last = at; last < count && t[last + 1] <= $7;) ++last
    if (last <= first && at > 0 && last < count) { first = at; ++last }
    n = last > first ? periods[last] - periods[first] : 0
    all = $8 - $3; idle = $9 - $4; steal = $10 - $5; ours = $11 - $6 + $13
    printf "%s,%d,%d,%s,%.1f,%.1f\n", $1, n, missed[last] - missed[first], $12,
      100 * (all - idle - steal - ours) / all, 100 * steal / all }' \
  "$folder/counts" "$folder/marks" >"$folder/cut"
{ echo "kind,periods,missed,packets_per_s,others_percent,steal_percent"; cat "$folder/cut"; } \
  >"$windows"

awk -F, 'function sorted(a, n, i, j, v) {
    for (i = 2; i <= n; ++i) { v = a[i]; for (j = i; j > 1 && a[j - 1] > v; --j) a[j] = a[j - 1]; a[j] = v }
  }
  function median(a, n) { return n % 2 ? a[(n + 1) / 2] : (a[n / 2] + a[n / 2 + 1]) / 2 }
  # P(at least k of n fair coins)
  function tail(n, k, i, c, s) { c = 1; s = 0
    for (i = 0; i <= n; ++i) { if (i >= k) s += c; c = c * (n - i) / (i + 1) } return s / 2 ^ n }
  { kind[NR] = $1; n[NR] = $2; m[NR] = $3; rate[NR] = $4; others[NR] = $5; steal[NR] = $6 }
  END {
    print "kind,windows,packets_per_s,quiet_missed_percent,flood_missed_percent,median_d,low_d,high_d,above_0,p,verdict"
    for (w = 2; w < NR; w += 2) {
      k = kind[w]
      quiet = n[w - 1] + n[w + 1]
      if (n[w] < 1 || quiet < 1) { ++lost; continue }
      if (!(k in c)) order[++kinds] = k
      i = ++c[k]
      d[k, i] = 100 * m[w] / n[w] - 2 * 100 * (m[w - 1] + m[w + 1]) / quiet - 0.1
      qn[k] += quiet; qm[k] += m[w - 1] + m[w + 1]; fn[k] += n[w]; fm[k] += m[w]; r[k] += rate[w]
    }
    for (j = 1; j <= kinds; ++j) {
      k = order[j]; size = c[k]; above = 0
      for (i = 1; i <= size; ++i) { a[i] = d[k, i]; above += a[i] > 0 }
      sorted(a, size)
      for (cut = 1; cut < size / 2 && tail(size, size - cut) <= 0.025; ++cut) {}
      low = a[cut]; high = a[size + 1 - cut]
      verdict = size < 6 ? "too few" : low > 0 ? "exceeds" : high <= 0 ? "keeps" : "open"
      printf "%s,%d,%.0f,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%.3f,%s\n", k, size, r[k] / size,
        100 * qm[k] / qn[k], 100 * fm[k] / fn[k], median(a, size), low, high, above,
        tail(size, above), verdict | "sort"
    }
    close("sort")
    for (w = 1; w <= NR; ++w) { o[w] = others[w]; s[w] = steal[w] }
    sorted(o, NR); sorted(s, NR)
    for (w = 1; w <= NR; ++w) {
      if (w > 2 && w < NR - 1) {
        before = w % 2 ? w - 2 : w - 1; after = w % 2 ? w + 2 : w + 1
        if (n[w] > 0 && n[before] + n[after] > 0) {
          ++judged[w % 2]
          above_bound[w % 2] += 100 * m[w] / n[w] > 200 * (m[before] + m[after]) / (n[before] + n[after]) + 0.1
        }
      }
      all_n[w % 2] += n[w]; all_m[w % 2] += m[w]
    }
    printf "# above the bound: %d of %d flooded windows, %d of %d quiet ones judged the same\n",
      above_bound[0], judged[0], above_bound[1], judged[1]
    printf "# flooded: %.3f %% of %d periods missed\n", 100 * all_m[0] / all_n[0], all_n[0]
    printf "# quiet: %.3f %% of %d periods missed; %d windows without two statuses left out\n", 100 * all_m[1] / all_n[1], all_n[1], lost
    printf "# others: median %.1f %%, most %.1f %%; steal: median %.1f %%, most %.1f %%\n",
      median(o, NR), o[NR], median(s, NR), s[NR]
  }' "$folder/cut"
