#!/usr/bin/env bash
# Calibrates a machine from 219 touches and asks for its errors at the nodes and between them.
#   samples/calibrate/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")"

"$trunnion" identify --machine machine.toml --observations replica.csv -o "$out/model.json" >"$out/identify.txt"
"$trunnion" evaluate --machine machine.toml --model "$out/model.json" --at positions.csv -o "$out/deviations.csv"
