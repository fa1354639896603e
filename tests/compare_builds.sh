#!/usr/bin/env bash
# Does another build compute the same? State hashes of every bundled scene and of the kidney's log of
# probes, and the tables of the reports, times left out. For changes that must not change what is
# computed.
#   compare_builds.sh [--relative R] BIN_A BIN_B [REPORT...]
#     BIN_A, BIN_B  folders of programs; the scenes are those of this tree
#     REPORT        accuracy stability (both with --quick), zhong2006 zhang2018 hybrid; hashes alone
#                   without; some minutes each
#     --relative R  numbers of tables that differ by no more than R of the larger are the same (0)
#   WORK: a folder to keep the reports in, gone on with where they are there; else a scratch one.
#
# Rows of `f_membrane` with hybrid and cnn-chainmail end by processor time, within one build too.
# Exit 1 when anything differs, with the first lines that do.
set -euo pipefail
cd "$(dirname "$0")/.."
relative=0
if [ "${1:-}" = --relative ]; then
  relative=$2
  shift 2
fi
if [ $# -lt 2 ] || [ ! -x "$1/softsim-run" ] || [ ! -x "$2/softsim-run" ]; then
  echo "compare_builds.sh: give two folders with softsim-run in them" >&2
  exit 2
fi
a=$(realpath "$1") b=$(realpath "$2")
shift 2
work=${WORK:-}
if [ -z "$work" ]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
fi
mkdir -p "$work/a" "$work/b"
status=0

hashes() { # BIN
  local scene
  for scene in server/scenes/*.yaml; do
    echo "$(basename "$scene"),$("$1/softsim-run" "$scene" --duration 0.3 --hash 2>/dev/null | tail -1)"
  done
  echo "kidney-poke,$("$1/softsim-run" server/scenes/kidney.yaml --poses server/scenes/kidney-poke.lcmlog \
    --hash 2>/dev/null | tail -1)"
}

# Rows of table A that differ from those of B, columns of run times left out.
differing() { # A B
  awk -v relative="$relative" '
    function split_row(line, out,    n, i, c, quoted) { # a comma in quotes is text
      n = 1; out[1] = ""; quoted = 0
      for (i = 1; i <= length(line); ++i) {
        c = substr(line, i, 1)
        if (c == "\"") quoted = !quoted
        if (c == "," && !quoted) out[++n] = ""
        else out[n] = out[n] c
      }
      return n
    }
    function number(text) { return text ~ /^[-+]?[0-9.]+([eE][-+]?[0-9]+)?$/ }
    function same(x, y,    d, m) {
      if (x == y) return 1
      if (!number(x) || !number(y)) return 0
      d = x - y; if (d < 0) d = -d
      m = x < 0 ? -x : +x; if ((y < 0 ? -y : +y) > m) m = y < 0 ? -y : +y
      return d <= relative * m
    }
    NR == FNR { left[FNR] = $0; left_rows = FNR; next }
    FNR == 1 {
      columns = split_row($0, name)
      for (i = 1; i <= columns; ++i)
        is_time[i] = name[i] ~ /(^|_)(us|ms|cpu|realtime|create)(_|$)|^time_to/
    }
    {
      if (FNR > left_rows) { print "only in the second: " $0; next }
      n = split_row(left[FNR], l); m = split_row($0, r); is_same = n == m
      for (i = 1; i <= n && is_same; ++i) is_same = is_time[i] || same(l[i], r[i])
      if (!is_same) print "< " left[FNR] "\n> " $0
    }
    END { for (i = FNR + 1; i <= left_rows; ++i) print "only in the first: " left[i] }' "$1" "$2"
}

compare() { # WHAT A B
  local rows
  rows=$(wc -l <"$2")
  differing "$2" "$3" >"$work/differing"
  if [ -s "$work/differing" ]; then
    echo "$1: differs, $(grep -cE '^(<|only)' "$work/differing") of $rows rows"
    head -n 20 "$work/differing"
    status=1
  else
    echo "$1: $rows rows, the same"
  fi
}

hashes "$a" >"$work/a/hashes.csv"
hashes "$b" >"$work/b/hashes.csv"
compare hashes "$work/a/hashes.csv" "$work/b/hashes.csv"

for report in "$@"; do
  case $report in
    accuracy | stability) command=("$report" --quick --jobs "$(nproc)") ;;
    zhong2006 | zhang2018 | hybrid) command=(paper "$report" --quick) ;;
    *) echo "compare_builds.sh: unknown report '$report'" >&2; exit 2 ;;
  esac
  for side in a b; do
    bin=$a
    [ "$side" = a ] || bin=$b
    code=0
    "$bin/softsim-bench" "${command[@]}" --out "$work/$side/$report" >"$work/$side/$report.log" 2>&1 || code=$?
    # 1: a claim or a run failed, which the tables tell; 2: it could not run
    [ "$code" -le 1 ] || { echo "compare_builds.sh: $bin: $report: exit $code" >&2; tail -3 "$work/$side/$report.log" >&2; exit 2; }
  done
  for table in "$work/a/$report"/*.csv; do
    other=$work/b/$report/$(basename "$table")
    [ -f "$other" ] || { echo "$report: no $(basename "$table") from the second"; status=1; continue; }
    compare "$report: $(basename "$table")" "$table" "$other"
  done
done
exit $status
