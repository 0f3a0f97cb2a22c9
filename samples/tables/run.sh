#!/usr/bin/env bash
# Writes the compensation tables of one calibrated machine for every controller.
#   samples/tables/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${1:-.}
trunnion=${TRUNNION:-trunnion}
calibrate=$here/../calibrate
mkdir -p "$out"

"$trunnion" identify --machine "$calibrate/machine.toml" --observations "$calibrate/replica.csv" -o "$out/model.json" >/dev/null
for controller in linuxcnc sinumerik-840d isg-twincat heidenhain fanuc-30i aerotech; do
  wanted=1
  if [ "$controller" = linuxcnc ]; then wanted=0; fi
  status=0
  "$trunnion" tables --machine "$calibrate/machine.toml" --model "$out/model.json" --controller "$controller" \
    --date 2026-11-23 -o "$out/$controller" >"$out/$controller.txt" || status=$?
  if [ "$status" -ne "$wanted" ]; then
    echo "$controller: exit status $status, $wanted is wanted" >&2
    exit 1
  fi
done
