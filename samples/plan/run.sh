#!/usr/bin/env bash
# Where to probe: a first calibration with its program, and what to add to one so that two effects are seen and told apart.
#   samples/plan/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")"
machine=../calibrate/machine.toml

"$trunnion" plan --machine $machine --nc linuxcnc -o "$out/first.csv" >"$out/first.txt"
"$trunnion" plan --machine $machine --observations ../calibrate/replica.csv --separate backlash:C,thermal_drift -o "$out/next.csv" \
  >"$out/next.txt"
# What the touches of a plan would leave unseen, before any is taken.
"$trunnion" doctor --machine $machine --observations "$out/first.csv" >"$out/doctor.txt"
