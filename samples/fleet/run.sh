#!/usr/bin/env bash
# Fifty machines over night: maps, tables, a corrected program and a predicted piece for each, and one table of all.
#   samples/fleet/run.sh [OUTPUT_FOLDER [MACHINES]]        TRUNNION names the program, if it is not on the PATH
set -euo pipefail
trunnion=${TRUNNION:-trunnion}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "${1:-.}"
cd "${1:-.}"

python3 "$here/make_fleet.py" machines "${2:-50}"
cp "$here/plan.toml" "$here/../correct/part.ngc" "$here/../correct/job.toml" "$here/../predict/piece.toml" .

run_all() {  # the lines of a file, on all processors, in whatever order
  if command -v parallel >/dev/null; then
    parallel --will-cite <"$1"
  else
    tr '\n' '\0' <"$1" | xargs -0 -r -P "$(nproc)" -I{} sh -c {}
  fi
}

"$trunnion" batch plan.toml -o out --program "$trunnion" >batch.txt
for stage in 1 2 3; do
  run_all out/jobs-$stage.txt || true  # a line ends with 1 where a table is a draft; what failed is missing below
done
"$trunnion" batch plan.toml -o out --merge >>batch.txt
