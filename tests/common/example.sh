#!/usr/bin/env bash
# The beginning of test_example_*.sh, sourced with their own arguments: $source_dir, $bin, a folder $work
# that goes at the end, fail, and how many lines the example has.
#   source tests/common/example.sh EXAMPLE MOST SOURCE_DIR BIN_DIR
set -euo pipefail
# shellcheck disable=SC2034 # for who sources it
source_dir=$3 bin=$4 work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$(basename "$0" .sh): $1" >&2; exit 1; }
lines=$(wc -l <"$source_dir/tests/$1")
[ "$lines" -lt "$2" ] || fail "the example has $lines lines; an example is shorter than $2"
