#!/usr/bin/env bash
# A haptic device is one file and one row: a bridge that was built with tests/example_device beside its
# own devices, nothing else changed, knows it and its option.
#   test_example_device.sh SOURCE_DIR BIN_DIR      BIN_DIR: of a build with that folder
# shellcheck source=tests/common/example.sh
source "$1/tests/common/example.sh" example_device/circle.c 80 "$@"
help=$("$bin/softsim-bridge" --help)
grep -q -- '--device .*circle' <<<"$help" || fail "softsim-bridge --help does not name it"
grep -q -- '--radius-mm' <<<"$help" || fail "softsim-bridge --help does not know its option"
"$bin/softsim-bridge" --device circle --radius-mm 20 --linear-tissue 300 --ticks 250 --csv "$work/out.csv" >/dev/null ||
  fail "it does not run"
# A quarter of a turn after the start: (0, 20 mm).
awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
  $column["x"]^2 + $column["y"]^2 < 0.0199^2 || $column["x"]^2 + $column["y"]^2 > 0.0201^2 { exit 1 }
  { y = $column["y"] } END { exit !(NR == 251 && y > 0.0199) }' "$work/out.csv" || fail "it is not a circle of 20 mm"
echo "test_example_device: $lines lines, one row"
