#!/usr/bin/env bash
# A reader of meshes is one file and one row: programs that were built with tests/example_reader beside
# their own readers, nothing else changed, read that format.
#   test_example_reader.sh SOURCE_DIR BIN_DIR      BIN_DIR: of a build with that folder
# shellcheck source=tests/common/example.sh
source "$1/tests/common/example.sh" example_reader/off.c 110 "$@"
printf 'OFF\n4 4 0\n0 0 0\n10 0 0\n0 10 0\n0 0 10\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' >"$work/tet.off"
said=$("$bin/softsim-mesh" info "$work/tet.off" --units mm) || fail "softsim-mesh info: $said"
grep -qE '^nodes +4$' <<<"$said" && grep -qE '^triangles +4$' <<<"$said" && grep -qE '^surface +closed$' <<<"$said" ||
  fail "not the mesh that was written: $said"
printf 'OFF\n4 4 0\n0 0 0\n10 0 0\n0 ten 0\n0 0 10\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n' >"$work/bad.off"
! said=$("$bin/softsim-mesh" info "$work/bad.off" --units mm 2>&1) || fail "a bad file is taken"
grep -q 'bad.off:5: ' <<<"$said" || fail "no line is named: $said"
echo nothing >"$work/none.xyz"
! said=$("$bin/softsim-mesh" info "$work/none.xyz" --units mm 2>&1) || fail "a file of no format is taken"
grep -q 'give .*OFF' <<<"$said" || fail "the formats that are read do not name OFF: $said"
echo "test_example_reader: $lines lines, one row"
