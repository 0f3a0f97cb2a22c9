#!/usr/bin/env bash
# A machine with an effect that nobody declared: what a calibration and a later measurement show of it, what it is, and what
# the model is worth with it.
#   samples/close/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")"
machine=../calibrate/machine.toml

"$trunnion" identify --quiet --machine $machine --observations calibration.csv -o "$out/before.json" >"$out/identify.txt"
"$trunnion" close --machine $machine --observations calibration.csv --verification later.csv \
  --predict ../predict/piece.toml -o "$out/closed" \
  >"$out/close.txt"
# The program, with the reversal of C taken out as well: closed/model.json is the extended model.
"$trunnion" correct --machine $machine --model "$out/closed/model.json" --job ../correct/job.toml ../correct/part.ngc \
  -o "$out/corrected.ngc" >"$out/correct.txt"
