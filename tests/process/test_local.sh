#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# Two hosts, as network namespaces joined by a cable (veth) that is the default route of both. By
# default a server hears its own host only: its clients, LCM's own programs, any program. The
# neighbour reaches it neither by multicast, whatever its TTL, nor by unicast. With an LCM URL of
# the user's own and a TTL the neighbour is heard, and its commands are taken where allowed.
#   test_local.sh BIN SCENE
set -uo pipefail
if [ -z "${INSIDE:-}" ]; then
  flags=-n
  [ "$(id -u)" = 0 ] || flags=-rn
  unshare "$flags" true 2>/dev/null || {
    echo "skipped: no private network namespace allowed here" >&2
    exit 77
  }
  INSIDE=1 exec unshare "$flags" "$0" "$@"
fi
bin=$1
scene=$2
unset LCM_DEFAULT_URL
group='udpm://239.255.76.67:7667?ttl=1'
folder=$(mktemp -d)
server=
unshare -n sleep 1000 &
neighbour=$!
trap 'kill $neighbour $server 2>/dev/null; rm -rf "$folder"' EXIT
bad=0
fault() { echo "test_local.sh: $1" >&2; bad=1; }
next() { nsenter -t "$neighbour" -n "$@"; }

# The neighbour's namespace is there when it is not ours.
for _ in $(seq 600); do
  [ "$(readlink /proc/$neighbour/ns/net)" = "$(readlink /proc/self/ns/net)" ] || break
  sleep 0.1
done
if ! { ip link set lo up && ip link add home type veth peer name away netns "$neighbour" &&
  ip addr add 10.9.0.1/24 dev home && ip link set home up && ip route add default dev home &&
  next ip link set lo up && next ip addr add 10.9.0.2/24 dev away && next ip link set away up &&
  next ip route add default dev away; } 2>"$folder/ip"; then
  echo "skipped: no cable between namespaces: $(cat "$folder/ip")" >&2
  exit 77
fi

start() {
  "$bin/softsimd" "$scene" "$@" >"$folder/out" 2>"$folder/err" &
  server=$!
  for _ in $(seq 600); do
    grep -q ready "$folder/out" && return
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
  done
  fault "no server: $(cat "$folder/err")"
}
stop() {
  kill -TERM "$server"
  wait "$server" || fault "the server ends with $?: $(cat "$folder/err")"
}
received() { "$bin/softsim-monitor" "$@" --once --json | sed -n 's/.*"poses_received": \([0-9]*\).*/\1/p'; }
# Five of each from next door.
attack() {
  for kind in pose-good command-shutdown command-reset fragment-wrap; do
    for way in '--ttl 0' '--ttl 1' '--ttl 255' '--to 10.9.0.1'; do
      next "$bin/flood" $kind $way --rate 100 --seconds 0.05 >/dev/null
    done
  done
}

# This host only.
start
attack
[ "$(received)" = 0 ] || fault "the neighbour is heard: $(received) messages"
kill -0 "$server" || fault "the neighbour shut the server down"
"$bin/flood" pose-good --rate 100 --seconds 0.05 >/dev/null
[ "$(received)" -ge 1 ] || fault "a program of this host is not heard"
"$bin/softsim-monitor" --command 'status' >/dev/null || fault "this host's command is not taken"
if command -v lcm-logger >/dev/null; then
  timeout 900 lcm-logger -q "$folder/log" &
  logger=$!
  for _ in $(seq 300); do
    grep -qa SOFTSIM_STATUS "$folder/log" 2>/dev/null && break
    received >/dev/null
  done
  kill "$logger"
  grep -qa SOFTSIM_STATUS "$folder/log" || fault "lcm-logger hears nothing of the server"
  wait "$logger" 2>/dev/null
fi
stop

# A group of the user's own, with a TTL: heard next door, and hears, but obeys only when told to.
start --lcm-url "$group"
next "$bin/flood" pose-good --ttl 1 --rate 100 --seconds 0.05 >/dev/null
[ "$(received --lcm-url "$group")" -ge 1 ] || fault "the neighbour is not heard with a TTL of 1"
next "$bin/softsim-monitor" --lcm-url "$group" --once --json | grep verdict >/dev/null ||
  fault "the server is not heard next door with a TTL of 1"
said=$(next "$bin/softsim-monitor" --lcm-url "$group" --command shutdown)
[[ "$said" == *--allow-commands* ]] || fault "shutdown with a URL of one's own: '$said'"
stop
start --lcm-url "$group" --allow-commands
next "$bin/softsim-monitor" --lcm-url "$group" --command shutdown >/dev/null ||
  fault "shutdown with --allow-commands is refused"
wait "$server" || fault "the server ends with $? after shutdown"
[ "$bad" != 0 ] || echo "test_local.sh: this host only, unless told otherwise"
exit "$bad"
