#!/usr/bin/env bash
# Calibrates a machine from 219 touches and asks for its errors at the nodes and between them.
#   samples/calibrate/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${1:-.}
trunnion=${TRUNNION:-trunnion}
mkdir -p "$out"

"$trunnion" identify --machine "$here/machine.toml" --observations "$here/replica.csv" \
  -o "$out/model.json" >"$out/identify.txt"
"$trunnion" evaluate --machine "$here/machine.toml" --model "$out/model.json" --at "$here/positions.csv" \
  -o "$out/deviations.csv"
