#!/usr/bin/env bash
# A reader of meshes is one file and one row: programs that were built with tests/example_reader beside
# their own readers, nothing else changed, read that format.
#   test_example_reader.sh SOURCE_DIR BIN_DIR      BIN_DIR: of a build with that folder
# shellcheck source=tests/common/example.sh
source "$1/tests/common/example.sh" example_reader/medit.c 110 "$@"
write() { # FILE COORDINATE: a tetrahedron of 10, one of whose coordinates is that
  printf 'MeshVersionFormatted 1\nDimension 3\nVertices\n4\n0 0 0 1\n10 0 0 1\n0 %s 0 1\n0 0 10 1\n' "$2" >"$1"
  printf 'Triangles\n4\n1 3 2 1\n1 2 4 1\n2 3 4 1\n3 1 4 1\nEnd\n' >>"$1"
}
write "$work/tet.mesh" 10
said=$("$bin/softsim-mesh" info "$work/tet.mesh" --units mm) || fail "softsim-mesh info: $said"
grep -qE '^nodes +4$' <<<"$said" && grep -qE '^triangles +4$' <<<"$said" && grep -qE '^surface +closed$' <<<"$said" ||
  fail "not the mesh that was written: $said"
write "$work/bad.mesh" ten
! said=$("$bin/softsim-mesh" info "$work/bad.mesh" --units mm 2>&1) || fail "a bad file is taken"
grep -q 'bad.mesh:7: ' <<<"$said" || fail "no line is named: $said"
echo nothing >"$work/none.xyz"
! said=$("$bin/softsim-mesh" info "$work/none.xyz" --units mm 2>&1) || fail "a file of no format is taken"
grep -q 'give .*Medit' <<<"$said" || fail "the formats that are read do not name Medit: $said"
echo "test_example_reader: $lines lines, one row"
