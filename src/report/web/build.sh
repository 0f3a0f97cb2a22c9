#!/usr/bin/env bash
# Bundles page.js with uPlot and three.js to page.bundle.js, and gathers their licences. Run after a change of page.js or of
# a version in package.json; what it writes is kept in the repository, so that building Trunnion needs no npm.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cp package.json package-lock.json page.js charts.js part.js "$place"
cd "$place"
npm ci --ignore-scripts --silent --no-audit --no-fund
# No "</script" may end the page's element early; esbuild writes it as "<\/script".
node node_modules/esbuild/bin/esbuild page.js --bundle --minify --format=iife --target=es2020 --charset=ascii \
  --legal-comments=none --loader:.css=text --outfile=page.bundle.js --log-level=warning
{
  for name in uplot three; do
    printf '%s %s\n\n' "$name" "$(node -p "require('./node_modules/$name/package.json').version")"
    cat "node_modules/$name/LICENSE"
    printf '\n\n'
  done
} >LICENCES.txt
cd - >/dev/null
cp "$place/page.bundle.js" "$place/LICENCES.txt" .
