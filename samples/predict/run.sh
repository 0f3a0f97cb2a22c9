#!/usr/bin/env bash
# What a measuring machine will find on a cone frustum cut on the calibrated machine, as it is and with its program
# corrected.
#   samples/predict/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${1:-.}
trunnion=${TRUNNION:-trunnion}
mkdir -p "$out"

"$trunnion" identify --machine "$here/../calibrate/machine.toml" --observations "$here/../calibrate/replica.csv" \
  -o "$out/model.json" >"$out/identify.txt"
"$trunnion" predict --machine "$here/../calibrate/machine.toml" --model "$out/model.json" --piece "$here/piece.toml" \
  --corrected --sensitivity -o "$out/piece" >"$out/predict.txt"
