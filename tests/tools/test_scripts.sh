#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# The command lines of tools/*.sh: each answers at once, before it installs or builds anything.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
bad=0

# expect STATUS TEXT COMMAND...: exit status, and a text on stdout or stderr.
expect() {
  local status=$1 text=$2 said got=0
  shift 2
  said=$(timeout 900 "$@" 2>&1) || got=$?
  if [ "$got" != "$status" ] || [[ "$said" != *"$text"* ]]; then
    echo "$*: status $got, not $status with '$text': $said" >&2
    bad=1
  fi
}

expect 2 "--seconds needs a whole number" tools/demo.sh --seconds
expect 2 "--seconds needs a whole number" tools/demo.sh --seconds=
expect 2 "--seconds needs a whole number" tools/demo.sh --seconds ten
# Every option lets the next be read: alone, first and last.
expect 2 "--seconds needs a whole number" tools/demo.sh --no-web --seconds ten
expect 2 "--seconds needs a whole number" tools/demo.sh --seconds 5 --no-web --seconds=ten
expect 2 "unknown argument '--fast'" tools/demo.sh --fast
expect 2 "unknown argument '--fast'" tools/demo.sh --seconds=5 --no-web --fast
expect 2 "unknown argument '--fast'" tools/test.sh --fast
expect 2 "one argument too many" tools/test.sh --quick --quick
expect 2 "'none' is no model; there are" tools/single_models.sh fem none
expect 2 "unknown set 'everything'" tools/setup.sh everything
# Reports draw with gnuplot; a fresh machine must get it with what builds them.
if ! grep -q '^build=' tools/setup.sh || ! sed -n '/^build=/,/"$/p' tools/setup.sh | grep gnuplot-nox >/dev/null; then
  echo "tools/setup.sh build does not install gnuplot-nox" >&2
  bad=1
fi
# A tree that was copied together with its builds builds itself, not the one that it came from; its
# own builds stay, and what stands elsewhere is not touched.
expect 2 "unknown argument '--all'" tools/own_builds.sh --all
copy=$(mktemp -d)
mkdir -p "$copy/tools" "$copy/build/release" "$copy/build/dev" "$copy/build/empty" "$copy/elsewhere"
cp tools/own_builds.sh "$copy/tools"
echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" | tee "$copy/build/release/CMakeCache.txt" >"$copy/elsewhere/CMakeCache.txt"
echo "CMAKE_HOME_DIRECTORY:INTERNAL=$copy" >"$copy/build/dev/CMakeCache.txt"
expect 0 "build/release is a build of $PWD, not of this tree; starting afresh" "$copy/tools/own_builds.sh"
if [ -e "$copy/build/release" ] || [ ! -e "$copy/build/dev" ] || [ ! -e "$copy/build/empty" ] ||
  [ -n "$("$copy/tools/own_builds.sh" 2>&1)" ]; then
  echo "own_builds.sh: removed the wrong builds" >&2
  bad=1
fi
ln -s ../elsewhere "$copy/build/linked"
expect 1 "build/linked is a link to a build of $PWD" "$copy/tools/own_builds.sh"
if [ ! -e "$copy/elsewhere/CMakeCache.txt" ]; then
  echo "own_builds.sh: removed what is elsewhere" >&2
  bad=1
fi
rm -rf "$copy"
for script in demo test; do
  if ! grep -q '^tools/own_builds.sh$' tools/$script.sh; then
    echo "tools/$script.sh does not look for builds of another tree" >&2
    bad=1
  fi
done
for script in demo test setup own_builds single_models lcm-spy; do
  expect 0 "tools/$script.sh" tools/$script.sh --help
  if tools/$script.sh --help | grep -E '^(#|set -)' >/dev/null; then
    echo "tools/$script.sh --help prints its source" >&2
    bad=1
  fi
done

# What is written beside the build has a name nobody can foresee.
if grep -nE '/tmp/|\$\$[^_"]*\.' tools/*.sh tests/fuzz/run.sh; then
  echo "a script writes under a name that can be foreseen: use mktemp" >&2
  bad=1
fi
exit $bad
