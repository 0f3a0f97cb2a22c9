#!/usr/bin/env bash
# Sets up, builds, and does the main job on sample data: touches on a machine's table -> error maps with uncertainty ->
# the maps anywhere -> a corrected five-axis program. From a bare clone on Debian 12; asks nothing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
out=build/demo

cmake/install-dependencies.sh
cmake --preset release >&2
cmake --build --preset release --target trunnion >&2
trunnion=build/release/trunnion
rm -rf "$out"
mkdir -p "$out"

step() { printf '\n== %s\n\n' "$1"; }
run() {
  printf '$ trunnion'
  printf ' %s' "$@"
  printf '\n'
  "$trunnion" "$@" 2>&1
}
# columns FILE NAME …: the named columns of a CSV file, numbers rounded to three decimals.
columns() {
  awk -F, -v names="${*:2}" '
    NR == 1 { n = split(names, wanted, " "); for (i = 1; i <= NF; i++) place[$i] = i
              for (i = 1; i <= n; i++) printf "%11s", wanted[i]; print ""; next }
    { for (i = 1; i <= n; i++) { v = $(place[wanted[i]])
        if (v ~ /^-?[0-9]+$/ || v !~ /^[-+0-9.eE]+$/) printf "%11s", v; else printf "%11.3f", v }; print "" }' "$1"
}

step "1. From 219 touches on three columns to the twelve errors of the two rotary axes"
run identify --machine samples/calibrate/machine.toml --observations samples/calibrate/replica.csv -o "$out/model.json"

step "2. The maps at the measured positions and between them, with standard uncertainty"
run evaluate --machine samples/calibrate/machine.toml --model "$out/model.json" --at samples/calibrate/positions.csv \
  -o "$out/deviations.csv"
columns "$out/deviations.csv" what A_deg C_deg x_mm y_mm z_mm dx_um dy_um dz_um sd_um Da_urad Db_urad Dc_urad |
  awk 'NR == 1 || /between/'
echo
echo "Against the errors that the simulated machine was given, root mean square over the 23 measured positions:"
awk -F, '
  FNR == 1 { for (i = 1; i <= NF; i++) place[FILENAME, $i] = i; next }
  { key = $(place[FILENAME, "A_deg"]) " " $(place[FILENAME, "C_deg"]) }
  FILENAME == ARGV[1] { for (c in wanted) truth[key, wanted[c]] = $(place[FILENAME, wanted[c]]); next }
  $(place[FILENAME, "what"]) == "node" && key != "0 0" {
    poses++
    for (c in wanted) { e = $(place[FILENAME, wanted[c]]) - truth[key, wanted[c]]; sum[c] += e * e } }
  BEGIN { split("Dx_um Dy_um Dz_um Da_urad Db_urad Dc_urad", wanted, " ") }
  END { for (c = 1; c <= 6; c++) printf "  %s %.3f", wanted[c], sqrt(sum[c] / poses); print "" }
' samples/calibrate/truth.csv "$out/deviations.csv"

step "3. A five-axis program, corrected"
run correct --machine samples/calibrate/machine.toml --model "$out/model.json" --job samples/correct/job.toml \
  samples/correct/part.ngc -o "$out/corrected.ngc" --report "$out/report.json"
echo
echo "As programmed and as corrected, the first blocks that differ:"
diff --side-by-side --suppress-common-lines --width=120 samples/correct/part.ngc "$out/corrected.ngc" | head -n 14 || true

step "4. Does the map explain the readings, or is something missing? And all of it on one page"
run close --machine samples/calibrate/machine.toml --observations samples/calibrate/replica.csv -o "$out/closed"
run report "$out" -o "$out/report.html"

printf '\nThe results are in %s; open %s in a browser.\n' "$out" "$out/report.html"
