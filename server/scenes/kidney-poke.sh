#!/bin/sh
# shellcheck disable=SC2034 # its variables are for those who read it
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# Where to touch the kidney: read (`. kidney-poke.sh`) for the simulated bridge's options, run to
# make kidney-poke.lcmlog again:
#   server/scenes/kidney-poke.sh [folder of softsim-replay]
#
# The bridge's contact frame: z out of the upper face, its origin where the 5 mm sphere touches.
KIDNEY_BRIDGE="--offset-m 0,0.006,0.0273"
# The other hand's, on the lower face: z out of the tissue is the world's -z.
KIDNEY_SECOND="--axes x,-y,-z --offset-m 0,0.006,-0.0273"

case "$0" in
*kidney-poke.sh)
    set -eu
    here=$(cd "$(dirname "$0")" && pwd)
    replay=${1:+$1/}softsim-replay
    csv=$(mktemp --suffix=.csv)
    trap 'rm -f "$csv"' EXIT
    awk -f "$here/kidney-poke.awk" "$here/kidney.obj" >"$csv"
    "$replay" --convert "$csv" "$here/kidney-poke.lcmlog"
    ;;
esac
