#!/usr/bin/env bash
# What a measuring machine will find on a cone frustum cut on the calibrated machine: as it is, under the tables of two
# controllers, and with its program corrected.
#   samples/predict/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${1:-.}
trunnion=${TRUNNION:-trunnion}
machine=$here/../calibrate/machine.toml
mkdir -p "$out"

"$trunnion" identify --machine "$machine" --observations "$here/../calibrate/replica.csv" -o "$out/model.json" \
  >"$out/identify.txt"
"$trunnion" tables --machine "$machine" --model "$out/model.json" --controller linuxcnc -o "$out/linuxcnc" >/dev/null
# Exit status 1: drafts, because the machine file does not confirm what the SINUMERIK leaves open.
"$trunnion" tables --machine "$machine" --model "$out/model.json" --controller sinumerik-840d -o "$out/sinumerik" \
  >/dev/null || [ $? -eq 1 ]
"$trunnion" predict --machine "$machine" --model "$out/model.json" --piece "$here/piece.toml" --tables "$out/linuxcnc" \
  --corrected --sensitivity -o "$out/piece" >"$out/predict.txt"
"$trunnion" predict --machine "$machine" --model "$out/model.json" --piece "$here/piece.toml" --tables "$out/sinumerik" \
  -o "$out/piece_sinumerik" >"$out/sinumerik.txt"
