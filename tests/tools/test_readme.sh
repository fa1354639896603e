#!/usr/bin/env bash
# The commands of README.md and of each folder's README, as they stand: every ```sh block runs to its
# end, each of its commands with exit status 0, in a scratch folder that looks like this one and a
# network of its own. A block after a line "<!-- not run: REASON -->" is left out; any other block that
# begins with "# NAME" is written to NAME before.
#   test_readme.sh SOURCE_DIR BUILD_DIR
set -euo pipefail
shopt -s nullglob
source_dir=$1 build_dir=$2
flags=-n
[ "$(id -u)" = 0 ] || flags=-rn
unshare $flags true 2>/dev/null || { echo "test_readme: no private network here" >&2; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/top/build" "$work/blocks"
for entry in "$source_dir"/*; do
  [ "${entry##*/}" = build ] || ln -s "$entry" "$work/top/"
done
ln -s "$build_dir" "$work/top/build/release"
cd "$work/top"

# Files first, since a text may show one after the commands that read it.
ran=0 passed_over=0
while IFS= read -r readme; do
  rm -f "$work"/blocks/*
  awk -v to="$work/blocks" '
    /^```/ && inside { inside = 0; close(file); next }
    /^```/ {
      inside = 1; n++; file = sprintf("%s/%03d.%s", to, n, /^```sh$/ ? (reason != "" ? "not" : "sh") : "text")
      printf "" >file
      if (/^```sh$/ && reason != "") print reason >file
      reason = ""; next
    }
    inside && file !~ /not$/ { print >file; next }
    { reason = /^<!-- not run: .* -->$/ ? $0 : "" }' "$source_dir/$readme"
  for text in "$work"/blocks/*.text; do
    name=$(sed -nE '1s/^# ([a-z0-9_.-]+)$/\1/p' "$text")
    [ -z "$name" ] || cp "$text" "$name"
  done
  for block in "$work"/blocks/*.sh; do
    # shellcheck disable=SC2016
    PATH=$build_dir/bin:$PATH timeout 600 unshare $flags bash -eu -c '
      ip link set lo up && ip route add 224.0.0.0/4 dev lo
      trap "kill \$(jobs -p) 2>/dev/null || true" EXIT
      . "$1"' block "$block" >"$work/out" 2>&1 </dev/null || {
      cat "$work/out" "$block" >&2
      echo "test_readme: $readme: the block above fails" >&2
      exit 1
    }
    ran=$((ran + 1))
  done
  marked=("$work"/blocks/*.not)
  passed_over=$((passed_over + ${#marked[@]}))
done < <(cd "$source_dir" && find . -name README.md -not -path './build*' -not -path '*/node_modules/*' | sed 's#^\./##' | sort)
[ "$ran" -ge 3 ] || { echo "test_readme: only $ran blocks found" >&2; exit 1; }
[ "$passed_over" -le 1 ] || { echo "test_readme: $passed_over blocks are marked as not run" >&2; exit 1; }
echo "test_readme: $ran blocks ran, $passed_over passed over"
