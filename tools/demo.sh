#!/usr/bin/env bash
# The demo: the daemon on the bundled kidney, a simulated haptic device pressing it, live figures, and
# the kidney in a browser, where the mouse is a second probe.
#   tools/demo.sh [--seconds N] [--no-web]     default: until Ctrl-C
# Sets everything up on a fresh Debian 12. Exit 0 when forces flowed and nothing failed.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=0 web=1
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds) seconds="${2:-}"; shift; [ $# = 0 ] || shift ;;
    --seconds=*) seconds="${1#*=}"; shift ;;
    --no-web) web=""; shift ;;
    --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "demo.sh: unknown argument '$1'; use --seconds N or --no-web" >&2; exit 2 ;;
  esac
done
[[ "$seconds" =~ ^[0-9]+$ ]] || { echo "demo.sh: --seconds needs a whole number" >&2; exit 2; }

tools/setup.sh build
tools/own_builds.sh
if [ ! -f build/release/build.ninja ]; then
  cmake --preset release -DSOFTSIM_WERROR=OFF >/dev/null
fi
# The programs, not their tests. Its progress is ninja's own on a terminal, a line every ten seconds
# elsewhere; what it said is shown when it fails.
programs=(server/all clients/all tools/all)
steps=$(ninja -C build/release -n "${programs[@]}" | sed -n 's/^\[\([0-9]*\)\/.*/\1/p' | tail -1)
if [ "${steps:-0}" -gt 20 ]; then
  echo "demo.sh: building $steps parts into build/release, about $((steps / $(nproc) / 60 + 1)) minutes;" \
    "the next start does without" >&2
fi
if [ -t 2 ]; then
  NINJA_STATUS="[%f of %t, %e s] " cmake --build --preset release --target "${programs[@]}" >&2
else
  log=$(mktemp)
  while sleep 10 >/dev/null 2>&1; do # which nobody waits for at the end
    sed -n 's/^\(\[[^]]*\]\).*/demo.sh: built \1/p' "$log" | tail -1 >&2
  done &
  ticker=$!
  built=0
  cmake --build --preset release --target "${programs[@]}" >"$log" 2>&1 || built=$?
  kill "$ticker"
  [ "$built" = 0 ] || cat "$log" >&2
  rm -f "$log"
  [ "$built" = 0 ] || exit 1
fi

# Local multicast: with no route for it, run inside a private network namespace.
if [ -z "${SOFTSIM_DEMO_INSIDE:-}" ] && ! ip route get 239.255.76.67 >/dev/null 2>&1; then
  echo "demo.sh: no multicast route here; running in a private network namespace" >&2
  echo "demo.sh: (to use the machine's own: ip route add 224.0.0.0/4 dev lo)" >&2
  flags=-n; [ "$(id -u)" = 0 ] || flags=-rn
  if [ -n "$web" ]; then
    echo "demo.sh: no page there: a browser would have to be inside too" >&2
  fi
  SOFTSIM_DEMO_INSIDE=1 exec unshare $flags bash -c \
    'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' demo tools/demo.sh --seconds "$seconds" --no-web
fi

bin=build/release/bin
prefix="DEMO_$$"
work=$(mktemp -d)
pids=()
finish() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap finish EXIT
trap 'stopped=1' INT TERM HUP
stopped=""

: >"$work/out" # the loop below may look before the shell in the background has made it
$bin/softsimd server/scenes/kidney.yaml --prefix "$prefix" >"$work/out" 2>"$work/err" &
daemon=$!
pids+=("$daemon")
until grep -q '^softsimd: ready' "$work/out"; do
  kill -0 "$daemon" 2>/dev/null || { cat "$work/err" >&2; echo "demo.sh: softsimd did not start" >&2; exit 1; }
  sleep 0.05
done
# The page, on its usual port or where that is taken on a free one.
start_web() {
  $bin/softsim-web --prefix "$prefix" "$@" 2>"$work/web" &
  local pid=$!
  until grep -q 'in a browser' "$work/web"; do
    kill -0 "$pid" 2>/dev/null || return 1
    sleep 0.05
  done
  pids+=("$pid")
  sed 's/^softsim-web/demo.sh/' "$work/web" >&2
}
if [ -n "$web" ] && [ -x $bin/softsim-web ]; then
  start_web || start_web --port 0 || cat "$work/web" >&2
fi
bridge=()
[ "$seconds" = 0 ] || bridge=(--duration "$seconds")
$bin/softsim-bridge --device sim --script slide --prefix "$prefix" "${bridge[@]}" >"$work/bridge" 2>&1 &
client=$!
pids+=("$client")
$bin/softsim-monitor --prefix "$prefix" "${bridge[@]}" &
monitor=$!
pids+=("$monitor")

status=0
wait "$client" || status=$?
kill "$monitor" 2>/dev/null || true
wait "$monitor" 2>/dev/null || true
kill -TERM "$daemon" 2>/dev/null || true
wait "$daemon" || status=$?
echo
cat "$work/bridge" "$work/err"
[ -z "$stopped" ] || exit 0
if [ "$status" != 0 ]; then
  echo "demo.sh: failed (status $status)" >&2
  exit 1
fi
