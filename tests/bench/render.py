"""render.py OUT.md RESULT.json ...: one table a group (the part of a benchmark's name before the slash) from results in
Google Benchmark's form. RATIOS says which pairs are to be compared, and what is wanted of them."""

import json
import platform
import sys

GROUPS = {"machine": "The machine itself", "deviations": "Deviations at positions in no order, one core",
          "baking": "Preparing", "identification": "330 touches to error maps, in process",
          "reading": "Reading", "closure": "Closing the loop", "piece": "The test piece, all processors",
          "correct regular": "Correcting a regular program, file to file",
          "correct irregular": "Correcting an irregular program, file to file",
          "program parts": "The parts of correcting a regular program, one core, in memory"}
# (group, the fast one, begins with; the other, begins with; wanted)
RATIOS = [("deviations", "baked map", "scipy", 10),
          ("correct regular", "trunnion correct, two threads", "rs274", 12),
          ("correct irregular", "trunnion correct, two threads", "rs274", 6)]
# (group, begins with, items a second wanted)
WANTED = [("deviations", "baked map", 1e7)]
# (group, begins with, ms at most)
AT_MOST = [("identification", "joint fit", 3), ("closure", "657 touches, a backlash", 1000),
           ("piece", "envelope, a million rays", 20000), ("piece", "10 000 Monte Carlo draws", 30000)]
KNOWN = {"name", "run_name", "run_type", "repetitions", "repetition_index", "threads", "iterations", "real_time",
         "cpu_time", "time_unit", "items_per_second", "bytes_per_second", "family_index", "per_family_instance_index",
         "repetition_index", "aggregate_name", "aggregate_unit"}


def processor():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def quantity(value, unit):
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= factor:
            return f"{value / factor:.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}"


def main():
    out, files = sys.argv[1], sys.argv[2:]
    rows = []
    for name in files:
        with open(name, encoding="utf-8") as file:
            rows += json.load(file)["benchmarks"]
    results = {}  # medians where a program was run several times, in the order of the files
    for r in rows:
        if r.get("aggregate_name", "median") == "median":
            results[r.get("run_name", r["name"])] = r
    lines = ["# Performance", "",
             f"Written by `tests/bench/run.sh`; do not edit. {processor()}, one thread, "
             "built for plain x86-64 (preset `bench`).", ""]
    groups = list(dict.fromkeys(name.split("/", 1)[0] for name in results))
    for group in groups:
        lines += [f"## {GROUPS.get(group, group)}", "", "| what | time | rate | |", "| --- | --- | --- | --- |"]
        for name, r in results.items():
            if not name.startswith(group + "/"):
                continue
            rate = (quantity(r["items_per_second"], "/s") if "items_per_second" in r else
                    quantity(r["bytes_per_second"], "B/s") if "bytes_per_second" in r else "")
            extra = ", ".join(f"{k} {v:.3g}" for k, v in r.items() if k not in KNOWN and isinstance(v, (int, float)))
            lines.append(f"| {name.split('/', 1)[1]} | {r['real_time']:.3g} {r['time_unit']} | {rate} | {extra} |")
        lines.append("")

        def find(beginning):
            return next((r for n, r in results.items() if n.startswith(f"{group}/{beginning}")), None)

        for of, beginning, wanted in WANTED:
            if of == group and (r := find(beginning)):
                verdict = "met" if r["items_per_second"] >= wanted else "NOT met"
                lines += [f"Wanted of the {beginning}: {quantity(wanted, '/s')}; {verdict}.", ""]
        for of, beginning, wanted in AT_MOST:
            if of == group and (r := find(beginning)):
                taken = r["real_time"] * {"ns": 1e-6, "us": 1e-3, "ms": 1, "s": 1e3}[r["time_unit"]]
                lines += [f"Wanted of the {beginning}: at most {wanted} ms; {'met' if taken <= wanted else 'NOT met'}.", ""]
        for of, fast, slow, wanted in RATIOS:
            if of == group and (f := find(fast)) and (s := find(slow)):
                ratio = f["items_per_second"] / s["items_per_second"]
                lines += [f"The {fast} is {ratio:.3g} times as fast as {slow} in the same run; wanted: {wanted}, "
                          f"{'met' if ratio >= wanted else 'NOT met'}.", ""]
    with open(out, "w", encoding="utf-8") as file:
        file.write("\n".join(lines).rstrip() + "\n")


main()
