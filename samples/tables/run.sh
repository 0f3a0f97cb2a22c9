#!/usr/bin/env bash
# Writes the compensation tables of one calibrated machine for every controller.
#   samples/tables/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${1:-.}
trunnion=${TRUNNION:-trunnion}
calibrate=$here/../calibrate
mkdir -p "$out/small"

"$trunnion" identify --machine "$calibrate/machine.toml" --observations "$calibrate/replica.csv" -o "$out/model.json" >/dev/null
tables() {  # CONTROLLER MACHINE MODEL FOLDER [OPTION …]: the set, and its verification on standard output
  local wanted=1 status=0
  if [ "$1" = linuxcnc ]; then wanted=0; fi
  "$trunnion" tables --controller "$1" --machine "$2" --model "$3" -o "$4" --date 2026-11-23 "${@:5}" || status=$?
  if [ "$status" -ne "$wanted" ]; then
    echo "$1: exit status $status, $wanted is wanted" >&2
    exit 1
  fi
}
for controller in linuxcnc sinumerik-840d isg-twincat heidenhain fanuc-30i aerotech; do
  tables "$controller" "$calibrate/machine.toml" "$out/model.json" "$out/$controller" >"$out/$controller.txt"
  tables "$controller" "$here/small/machine.toml" "$here/small/model.json" "$out/small/$controller" --spacing 30 >/dev/null
done
