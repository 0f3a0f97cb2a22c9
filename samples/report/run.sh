#!/usr/bin/env bash
# One machine from probing to part, and the page that tells it: identification, what the maps lacked, tables, a corrected
# program, a test piece before and after.
#   samples/report/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${1:-.}
trunnion=${TRUNNION:-trunnion}
probed=$here/../probing/machine-02
machine=$probed/machine.toml
mkdir -p "$out/tables" "$out/blade"

"$trunnion" identify --machine "$machine" --observations "$probed/observations.csv" -o "$out/model.json" >/dev/null
"$trunnion" close --machine "$machine" --observations "$probed/observations.csv" \
  --verification "$probed/verification.csv" -o "$out/closed" >/dev/null
model=$out/closed/model.json
"$trunnion" tables --machine "$machine" --model "$model" --controller linuxcnc -o "$out/tables/linuxcnc" >/dev/null
# Exit status 1: drafts, because the machine file does not confirm what the SINUMERIK leaves open.
"$trunnion" tables --machine "$machine" --model "$model" --controller sinumerik-840d -o "$out/tables/sinumerik-840d" \
  >/dev/null || [ $? -eq 1 ]
"$trunnion" correct --machine "$machine" --model "$model" --job "$here/job.toml" "$here/../programs/turbine_blade.ngc" \
  --dialect linuxcnc -o "$out/blade/turbine_blade.ngc" --report "$out/blade/correction.json" >/dev/null
"$trunnion" predict --machine "$machine" --model "$model" --piece "$here/../predict/piece.toml" --job "$here/job.toml" \
  --tables "$out/tables/linuxcnc" --corrected --draws 500 -o "$out/piece" >/dev/null

"$trunnion" report "$out" -o "$out/report.html"
# What stands on the page, by its headings and tables.
grep -o '<h[23][^>]*>[^<]*\|<caption>[^<]*\|<figcaption>[^<]*' "$out/report.html" | sed 's/<[^>]*>//' >"$out/contents.txt"
