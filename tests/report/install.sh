#!/usr/bin/env bash
# Puts playwright-core, which drives the browser of page_test.cjs, into a folder: install.sh FOLDER. Does nothing where it is.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "$1"
cmp -s "$here/package-lock.json" "$1/package-lock.json" && [ -d "$1/node_modules/playwright-core" ] && exit 0
cp "$here/package.json" "$here/package-lock.json" "$1"
cd "$1"
npm ci --ignore-scripts --silent --no-audit --no-fund
