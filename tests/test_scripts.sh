#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# The command lines of tools/*.sh: each answers at once, before it installs or builds anything.
set -uo pipefail
cd "$(dirname "$0")/.."
bad=0

# expect STATUS TEXT COMMAND...: exit status, and a text on stdout or stderr.
expect() {
  local status=$1 text=$2 said got=0
  shift 2
  said=$(timeout 10 "$@" 2>&1) || got=$?
  if [ "$got" != "$status" ] || [[ "$said" != *"$text"* ]]; then
    echo "$*: status $got, not $status with '$text': $said" >&2
    bad=1
  fi
}

expect 2 "--seconds needs a whole number" tools/demo.sh --seconds
expect 2 "--seconds needs a whole number" tools/demo.sh --seconds=
expect 2 "--seconds needs a whole number" tools/demo.sh --seconds ten
expect 2 "unknown argument '--fast'" tools/demo.sh --fast
expect 2 "unknown argument '--fast'" tools/test.sh --fast
expect 2 "one argument too many" tools/test.sh --quick --quick
expect 2 "unknown set 'everything'" tools/setup.sh everything
# Reports draw with gnuplot; a fresh machine must get it with what builds them.
if ! grep -q '^build=' tools/setup.sh || ! sed -n '/^build=/,/"$/p' tools/setup.sh | grep -q gnuplot-nox; then
  echo "tools/setup.sh build does not install gnuplot-nox" >&2
  bad=1
fi
for script in demo test setup lcm-spy; do
  expect 0 "tools/$script.sh" tools/$script.sh --help
  if tools/$script.sh --help | grep -qE '^(#|set -)'; then
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
