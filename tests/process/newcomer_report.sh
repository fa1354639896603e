#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# How many newcomers a server answers while others flood it with requests or commands; a second after
# the flood began. Not a test: the figures are the machine's. Inside a private network namespace.
#   newcomer_report.sh BIN SCENE [KIND [RATES [SENDERS [TRIES]]]]
#     command-status   "1200 5000 20000 0"   "8 24 32 40 64 128 0"   6
#   RATES packets a second of all who flood, 0: as fast as it goes; SENDERS 0: ever new ones.
# A newcomer asks once, from an address of its own, and waits for 1.6 s; the next comes 0.5 s later.
set -uo pipefail
bin=$1
scene=$2
kind=${3:-command-status}
rates=${4:-1200 5000 20000 0}
senders=${5:-8 24 32 40 64 128 0}
tries=${6:-6}
if [ -z "${INSIDE:-}" ]; then
  # shellcheck disable=SC2016
  INSIDE=1 exec unshare -n bash -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' \
    report "$0" "$@"
fi
unset LCM_DEFAULT_URL
folder=$(mktemp -d)
server='' flood=''
# shellcheck disable=SC2086
trap 'kill $server $flood 2>/dev/null; rm -rf "$folder"' EXIT
command=status
[ "$kind" = command-status ] || command=resume

echo "kind,packets_per_s,senders,asked,answered"
for rate in $rates; do
  for count in $senders; do
    "$bin/softsimd" --realtime off "$scene" --log-level error >"$folder/out" 2>"$folder/err" &
    server=$!
    until grep -q ready "$folder/out" 2>/dev/null; do sleep 0.1; done
    "$bin/flood" "$kind" --rate "$rate" --sockets "$count" --seconds 600 >/dev/null &
    flood=$!
    sleep 1
    answered=0
    for ((i = 0; i < tries; ++i)); do
      sleep 0.5
      timeout 1.6 "$bin/softsim-monitor" --command "$command" >/dev/null 2>&1 && ((++answered))
    done
    echo "$kind,$rate,$count,$tries,$answered"
    kill "$flood" "$server"
    wait "$flood" "$server" 2>/dev/null
  done
done
