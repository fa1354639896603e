#!/usr/bin/env bash
# Bundles the modules of softsim-web's page, clients/web/page, into clients/web/dist, which is in the
# repository: who builds the programs needs no node. Needs npm, and the registry at first.
#   tools/build_page.sh          makes dist anew, with the checksums of it and of its sources
#   tools/build_page.sh --sums   are dist and the sources what they were when it was made? No node
#   tools/build_page.sh --check  is dist what the sources give? Builds it again; exit 1 if not,
#                                77 where the modules are not there (tools/setup.sh browser)
set -euo pipefail
cd "$(dirname "$0")/.."
page=clients/web/page dist=clients/web/dist sums=clients/web/dist/SHA256SUMS
refuse() {
  echo "build_page.sh: $dist is not what $page gives; run tools/build_page.sh" >&2
  exit 1
}
case "${1:-}" in
  "") out=$dist ;;
  --sums) sha256sum --check --quiet $sums || refuse; exit 0 ;;
  --check) out=$(mktemp -d); trap 'rm -rf "$out"' EXIT ;;
  --help) sed -n '2,/^set /s/^# \{0,1\}//p' tools/build_page.sh; exit 0 ;;
  *) echo "build_page.sh: unknown argument '$1'; use --sums, --check or nothing" >&2; exit 2 ;;
esac
if ! [ -d $page/node_modules/three ] || ! command -v node >/dev/null; then
  [ $out = $dist ] || { echo "build_page.sh: no modules to build with here: tools/setup.sh browser" >&2; exit 77; }
  (cd $page && npm ci --ignore-scripts --no-audit --no-fund >/dev/null)
fi
$page/node_modules/.bin/esbuild $page/src/main.js --bundle --minify --format=esm --target=es2021 \
  --legal-comments=eof --log-level=warning --outfile="$out/app.js"
if [ "$out" = $dist ]; then
  LC_ALL=C sha256sum $dist/app.js $page/package-lock.json $page/src/*.js >$sums
else
  cmp $dist/app.js "$out/app.js" || refuse
fi
