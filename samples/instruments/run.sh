#!/usr/bin/env bash
# Readings of an R-test, a ball-bar, encoders and an autocollimator to error maps: the R-test by itself, what a ball-bar
# alone leaves unseen, and all of them together.
#   samples/instruments/run.sh [OUTPUT_FOLDER]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")"
machine=../calibrate/machine.toml

# only INSTRUMENT: its rows of the file
only() {
  awk -F, -v wanted="$1" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "artifact") k = i } NR == 1 || $k == wanted' \
    instruments.csv
}
only R-test >"$out/r-test.csv"
only ball-bar >"$out/ball-bar.csv"

"$trunnion" identify --quiet --machine $machine --observations "$out/r-test.csv" -o "$out/r-test.json" >"$out/r-test.txt"
"$trunnion" doctor --machine $machine --observations "$out/ball-bar.csv" --json |
  awk '/"id": "freedoms"/ { print before } { before = $0 }' >"$out/ball-bar.txt"
"$trunnion" identify --quiet --machine $machine --observations instruments.csv -o "$out/all.json" >"$out/all.txt"
