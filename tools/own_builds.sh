#!/usr/bin/env bash
# Removes builds of another source tree from build/: one that was copied or moved together with it
# would go on configuring and building the tree that it came from.
#   tools/own_builds.sh
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-}" in
  "") ;;
  --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) echo "own_builds.sh: unknown argument '$1'; it takes none" >&2; exit 2 ;;
esac
for cache in build/*/CMakeCache.txt; do
  [ -f "$cache" ] || continue
  home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$cache")
  [ ! "$home" -ef . ] || continue
  folder=${cache%/*}
  if [ "$(realpath "$folder")" != "$PWD/$folder" ] && [ "$(realpath "$folder")" != "$(pwd -P)/$folder" ]; then
    echo "own_builds.sh: $folder is a link to a build of $home; remove the link" >&2
    exit 1
  fi
  echo "own_builds.sh: $folder is a build of $home, not of this tree; starting afresh" >&2
  rm -rf "$folder"
done
