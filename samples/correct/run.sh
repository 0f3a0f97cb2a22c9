#!/usr/bin/env bash
# Corrects a five-axis program by the errors that samples/calibrate finds.
#   samples/correct/run.sh [OUTPUT_FOLDER]          TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")"

"$trunnion" identify --machine ../calibrate/machine.toml --observations ../calibrate/replica.csv \
  -o "$out/model.json" >"$out/identify.txt"
"$trunnion" correct --machine ../calibrate/machine.toml --model "$out/model.json" --job job.toml \
  part.ngc -o "$out/corrected.ngc" --report "$out/report.json" >"$out/correct.txt"
# A turbine blade as a CAM system posts it.
"$trunnion" correct --machine ../calibrate/machine.toml --model "$out/model.json" --job job.toml \
  ../programs/turbine_blade.ngc -o "$out/blade.ngc" >"$out/blade.txt"
