# For scripts that start a server and softsim-web, to be sourced: in a network of their own, with all
# that they start ended with them. $work is a folder that is removed at the end.

# Ends with 77, and says why, where there is no browser to try the page in.
need_browser() { # page folder
  local program
  for program in node chromium; do
    command -v $program >/dev/null || { echo "$(basename "$0"): no $program here: tools/setup.sh browser"; exit 77; }
  done
  [ -d "$1/node_modules/playwright-core" ] ||
    { echo "$(basename "$0"): no playwright-core here: tools/setup.sh browser"; exit 77; }
}

# Runs the script once more where nobody else speaks: enter_network "$@"
enter_network() {
  [ -z "${SOFTSIM_STAGE_INSIDE:-}" ] || return 0
  local flags=-n
  [ "$(id -u)" = 0 ] || flags=-rn
  unshare $flags true 2>/dev/null || { echo "$(basename "$0"): no private network here"; exit 77; }
  SOFTSIM_STAGE_INSIDE=1 exec unshare $flags bash -c \
    'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' stage "$0" "$@"
}

pids=()
open_stage() {
  work=$(mktemp -d)
  trap close_stage EXIT
}

end_all() {
  local pid
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait "${pids[@]}" 2>/dev/null || true
  pids=()
}

close_stage() {
  end_all
  rm -rf "$work"
}

# Starts a program and waits until it says that it is there; what it says is in $work/NAME.
start() { # name, what it says, program...
  local name=$1 said=$2
  shift 2
  : >"$work/$name"
  "$@" >"$work/$name" 2>&1 &
  pids+=("$!")
  until grep -q "$said" "$work/$name"; do
    kill -0 "${pids[-1]}" 2>/dev/null || { cat "$work/$name" >&2; exit 1; }
    sleep 0.05
  done
}

# softsim-web with these options; its address is then in $address.
start_web() { # binaries, options...
  local bin=$1
  shift
  start web 'in a browser' "$bin/softsim-web" --port 0 "$@"
  address=$(sed -n 's/.*open \(http:[^ ]*\) in a browser.*/\1/p' "$work/web")
}
