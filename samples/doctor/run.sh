#!/usr/bin/env bash
# Before anything is loaded on a machine: the sign test and its form, what the readings say of signs, units and zeros, and
# whether a model has the sign that the machine has.
#   samples/doctor/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")"
machine=../calibrate/machine.toml
readings=../calibrate/replica.csv

# The test to be run on the machine, and its form as it came back.
"$trunnion" doctor --quiet --machine $machine -o "$out" >"$out/machine.txt"
"$trunnion" doctor --machine $machine --form filled.csv >"$out/filled.txt"
# The same form from a machine whose C turns the other way: exit status 1.
status=0
"$trunnion" doctor --machine $machine --form reversed.csv >"$out/reversed.txt" || status=$?
[ "$status" -eq 1 ]
"$trunnion" identify --quiet --machine $machine --observations $readings -o "$out/model.json" >/dev/null
"$trunnion" doctor --machine $machine --observations $readings --model "$out/model.json" >"$out/readings.txt"
