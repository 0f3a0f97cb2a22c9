#!/bin/sh
# Builds the preset bench, runs every *_bench program and every *_bench.py, and writes docs/performance.md.
# A new benchmark: a trunnion_bench() in CMakeLists.txt, named group/what; render.py has the wanted numbers.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
cd "$root"
cmake --preset bench >/dev/null
cmake --build --preset bench -j"$(nproc)" --target benches >&2
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
for program in build/bench/bench/*_bench; do
  echo "$(basename "$program")" >&2
  "$program" --benchmark_repetitions=5 --benchmark_report_aggregates_only=true --benchmark_format=json \
    >"$results/$(basename "$program").json" 2>/dev/null
done
for script in "$here"/*_bench.py; do
  echo "$(basename "$script")" >&2
  "${TRUNNION_PYTHON:-/usr/bin/python3}" "$script" >"$results/$(basename "$script" .py)_py.json"
done
# The machine first, then by name.
/usr/bin/python3 "$here/render.py" docs/performance.md "$results/machine_bench.json" \
  $(ls "$results"/*.json | grep -v /machine_bench.json)
cat docs/performance.md
