#!/usr/bin/env bash
# A model is one folder and one row: of a program that was built with tests/example_model beside its
# own models, nothing else changed, that one appears where models do.
#   test_example_model.sh SOURCE_DIR BIN_DIR      BIN_DIR: of a build with that folder
# shellcheck source=tests/common/example.sh
source "$1/tests/common/example.sh" example_model/elastic_foundation.c 150 "$@"
"$bin/softsimd" --help | grep 'one of .*elastic-foundation' >/dev/null || fail "softsimd --help does not name it"
scene=$work/foundation.yaml
cat >"$scene" <<END
softsim: 1
object: {mesh: $source_dir/server/scenes/kidney.obj, units: mm}
model: {name: elastic-foundation, stiffness_n_per_m3: 5.0e+5}
contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]}
haptic: {max_force_n: 0.2}
END
"$bin/softsimd" --check "$scene" >/dev/null || fail "its scene is not good"
"$bin/softsim-run" "$scene" --duration 0.1 2>&1 | grep 'worst verdict good' >/dev/null || fail "it does not run well"
echo "test_example_model: $lines lines, one row"
