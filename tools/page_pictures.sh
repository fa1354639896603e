#!/usr/bin/env bash
# Takes the pictures of softsim-web's page: bodies pressed with the mouse, in a headless Chromium
# (tools/setup.sh browser); the film needs ImageMagick's convert too.
#   tools/page_pictures.sh FOLDER [BIN_DIR]     PNG and GIF files into FOLDER; 77: no browser here
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
[ $# -ge 1 ] || { echo "page_pictures.sh: give the folder for the pictures" >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mkdir -p "$1" && cd "$1" && pwd)
bin=$(cd "${2:-$root/build/release/bin}" && pwd)
work="" address="" # set by the next
# shellcheck source=tests/clients/browser/stage.sh
. "$root/tests/clients/browser/stage.sh"
page=$root/clients/web/page
need_browser "$page"
enter_network "$folder" "$bin"
open_stage

take() { # scene, picture or folder, options of take_pictures.mjs...
  local scene=$1 out=$2
  shift 2
  start server '^softsimd: ready' "$bin/softsimd" "$root/server/scenes/$scene.yaml"
  start_web "$bin"
  node "$root/tests/clients/browser/take_pictures.mjs" "$page" "$address" "$out" "$@"
  end_all
  echo "page_pictures.sh: $out"
}

take kidney "$folder/kidney.png" colour=potential at=0.012,0.006,0.022 depth=3
take liver "$folder/liver.png" colour=displacement at=-0.035,0,0.04 depth=4
take ventricle "$folder/ventricle.png" colour=energy at=-0.02,-0.024,0.01
take kidney "$folder/grasp.png" ghost at=0.012,0.006,0.022 grasp=-20,-70
take kidney "$folder/dark.png" dark colour=displacement at=0.012,0.006,0.022 depth=3
take kidney "$folder/phone.png" dark phone size=390x780 colour=displacement at=0.012,0.006,0.022 depth=3
if command -v convert >/dev/null; then
  mkdir "$work/film"
  take kidney "$work/film" film=40 colour=displacement at=0,0.006,0.022 depth=2
  convert -delay 10 "$work"/film/*.png -resize 400x +dither -colors 64 -layers optimize "$folder/press.gif"
fi
