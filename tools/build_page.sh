#!/usr/bin/env bash
# Bundles the page of softsim-web, clients/web/page, into clients/web/dist, which is in the
# repository: who builds the programs needs no node. Needs npm, and the registry at first.
#   tools/build_page.sh          makes dist anew
#   tools/build_page.sh --check  is dist what the sources give? exit 1 if not
set -euo pipefail
cd "$(dirname "$0")/.."
page=clients/web/page dist=clients/web/dist
case "${1:-}" in
  "") out=$dist ;;
  --check) out=$(mktemp -d); trap 'rm -rf "$out"' EXIT ;;
  --help) sed -n '2,/^set /s/^# \{0,1\}//p' tools/build_page.sh; exit 0 ;;
  *) echo "build_page.sh: unknown argument '$1'; use --check or nothing" >&2; exit 2 ;;
esac
[ -d $page/node_modules/three ] || (cd $page && npm ci --ignore-scripts --no-audit --no-fund >/dev/null)
mkdir -p "$out"
$page/node_modules/.bin/esbuild $page/src/main.js --bundle --minify --format=esm --target=es2021 \
  --legal-comments=eof --log-level=warning --outfile="$out/app.js"
cp $page/index.html $page/app.css $page/favicon.svg "$out/"
diff -rq $dist "$out" >/dev/null || {
  echo "build_page.sh: $dist is not what $page gives; run tools/build_page.sh" >&2
  exit 1
}
