#!/usr/bin/env bash
# Builds the preset `fuzz` (clang) and gives each reader many inputs, begun from the files of the project.
#
#   tests/fuzz/run.sh [RUNS] [TARGET …]
#
# RUNS is a million unless said; TARGET is the name of a program of this folder (nc_read_fuzz, machine_fuzz …), all unless said.
# A line a target; exit status 1 at the first finding, whose input is left in build/fuzz/findings.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

runs=${1:-1000000}
targets=("${@:2}")
cmake --preset fuzz >/dev/null
if [ ${#targets[@]} -eq 0 ]; then
  mapfile -t targets < <(ninja -C build/fuzz -t targets all | sed -n 's,^tests/fuzz/\([a-z0-9_]*_fuzz[a-z0-9_]*\): .*,\1,p' | sort -u)
fi
cmake --build --preset fuzz --target "${targets[@]}"
mkdir -p build/fuzz/findings

# What a reader reads, in files small enough to be changed everywhere.
seeds() {
  chosen "$1" || true  # nothing to begin from is no reason not to run
}
chosen() {
  local small=(-type f -size -9k)
  case $1 in
    machine_fuzz) find machines samples tests/rejected "${small[@]}" -name '*.toml' -print0 | xargs -0 grep -lZ trunnion-machine ;;
    job_fuzz) find samples tests/golden tests/rejected "${small[@]}" -name '*.toml' -print0 | xargs -0 grep -lZ -e work_offsets_mm -e '\[tools\]' ;;
    piece_fuzz) find samples tests/golden tests/rejected "${small[@]}" -name '*.toml' -print0 | xargs -0 grep -lZ trunnion-piece ;;
    observation_fuzz) find samples tests/rejected "${small[@]}" -name '*.csv' -print0 ;;
    model_fuzz) find samples tests/rejected "${small[@]}" -name '*.json' -print0 ;;
    nc_*_fuzz) find samples tests/golden tests/rejected "${small[@]}" \( -name '*.nc' -o -name '*.ngc' -o -name '*.mpf' -o -name '*.h' \) -print0 ;;
    probe_log_fuzz) find tests/fuzz "${small[@]}" -name '*.log' -print0 ;;
    tables_fuzz_*) find samples/tables "${small[@]}" -print0 ;;
  esac
}

for target in "${targets[@]}"; do
  corpus=build/fuzz/corpus/$target
  mkdir -p "$corpus"
  seeds "$target" | while IFS= read -r -d '' file; do
    # Programs and tables follow a byte that chooses the dialect, or the file of the set.
    name=$(sha1sum <"$file" | cut -c1-16) firsts=("")
    case $target in
      nc_*_fuzz) firsts=(1 5 9 = q) ;;
      tables_fuzz_*) firsts=(A B C D) ;;
    esac
    for first in "${firsts[@]}"; do { printf %s "$first" && cat "$file"; } >"$corpus/$name$first"; done
  done
  began=$(find "$corpus" -type f | wc -l)
  log=build/fuzz/$target.log
  # Short texts say what long ones can, a hundred times as often. The bookkeeping of rare features (-entropic) costs more
  # than half the time of quick targets.
  longest=8192
  case $target in
    nc_read_fuzz) longest=256 ;;
    nc_correct_fuzz) longest=128 ;;
  esac
  if ! "build/fuzz/tests/fuzz/$target" -runs="$runs" -max_len="$longest" -entropic=0 -timeout=60 -rss_limit_mb=4096 -artifact_prefix="build/fuzz/findings/$target-" \
    "$corpus" >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    echo "$target: a finding; see $log" >&2
    exit 1
  fi
  echo "$target: begun from $began files, $(grep -E '^Done [0-9]+ runs' "$log"), no finding"
done
