#!/usr/bin/env bash
# Corrects a five-axis program by the errors that samples/calibrate finds.
#   samples/correct/run.sh [OUTPUT_FOLDER]          TRUNNION names the program, if it is not on the PATH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${1:-.}
trunnion=${TRUNNION:-trunnion}
mkdir -p "$out"

"$trunnion" identify --machine "$here/../calibrate/machine.toml" --observations "$here/../calibrate/replica.csv" \
  -o "$out/model.json" >/dev/null
"$trunnion" correct --machine "$here/../calibrate/machine.toml" --model "$out/model.json" --job "$here/job.toml" \
  "$here/part.ngc" -o "$out/corrected.ngc" --report "$out/report.json"
