#!/usr/bin/env bash
# A year of calibrations: what moved, when, by how much; then a quick check that goes on from what is known.
#   samples/history/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")"

store=$out/shop.db
rm -f "$store"
for month in 01 03 05 07 09 11; do
  "$trunnion" identify --quiet --machine machine.toml --observations 2026-$month.csv -o "$out/$month.json" >"$out/$month.txt"
  "$trunnion" history add --store "$store" --machine machine.toml --model "$out/$month.json" --date 2026-$month-15 \
    --data 2026-$month.csv
done >"$out/add.txt"
"$trunnion" history list --store "$store" >"$out/list.txt"
"$trunnion" history compare 3 4 --store "$store" >"$out/compare.txt"
"$trunnion" history drift --quiet --store "$store" -o "$out/drift.json" >"$out/drift.txt"
# The alarm is what is wanted here: exit status 1.
status=0
"$trunnion" history trend --quiet --store "$store" --limits limits.toml -o "$out/trend.csv" >"$out/trend.txt" 2>"$out/alarms.txt" ||
  status=$?
[ "$status" -eq 1 ]
"$trunnion" history prior --quiet --store "$store" --date 2027-01-15 -o "$out/prior.json" >"$out/prior.txt"
"$trunnion" identify --quiet --machine machine.toml --observations 2027-01-check.csv --prior "$out/prior.json" \
  -o "$out/checked.json" >"$out/checked.txt"
