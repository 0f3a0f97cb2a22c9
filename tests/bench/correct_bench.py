#!/usr/bin/env python3
"""How fast `trunnion correct` is, beside LinuxCNC's rs274 merely reading the same file, and beside a plain copy.

    correct_bench.py [PROGRAM] [LINES]

Prints results in Google Benchmark's form. Each is the best of three runs, wall time, the programs taking turns; rs274 runs
on one core, as it is made, trunnion on two threads. Needs build/bench/trunnion; rs274 is left out where it is not installed.
"""
import json
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time

import nc_programs

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def timed(command, folder):
    start = time.perf_counter()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=folder, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                   env={"HOME": str(folder), "PATH": "/usr/bin:/bin"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (time.perf_counter() - start,
            after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def main():
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else SOURCE / "build/bench/trunnion").resolve()
    lines = int(sys.argv[2]) if len(sys.argv) > 2 else 1_000_000
    results = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "vars.var").write_text("")
        (folder / "tool.tbl").write_text("T1 P1 D10 Z0\n")
        for kind, write in (("regular", nc_programs.regular), ("irregular", nc_programs.irregular)):
            with open(folder / "in.ngc", "w", encoding="ascii") as out:
                write(lines, out)
            size = (folder / "in.ngc").stat().st_size
            count = sum(1 for _ in open(folder / "in.ngc", "rb"))
            correct = [str(program), "correct", "--machine", str(SOURCE / "machines/seed-trunnion.toml"), "--model",
                       str(SOURCE / "tests/golden/shared/model.json"), "in.ngc", "-o", "out.ngc", "--quiet"]
            commands = {"trunnion correct, two threads": correct,
                        "trunnion correct, one thread": correct + ["--threads", "1"],
                        "cp": ["cp", "in.ngc", "copy.ngc"]}
            if shutil.which("rs274"):
                commands["rs274 reads"] = ["rs274", "-t", "tool.tbl", "-v", "vars.var", "-g", "in.ngc", "/dev/null"]
            best = {}
            for _ in range(3):
                for what, command in commands.items():
                    best.setdefault(what, []).append(timed(command, folder))
            for what, runs in best.items():
                wall, cpu = min(runs)[0], min(run[1] for run in runs)
                results.append({"name": f"correct {kind}/{what}", "run_type": "iteration", "real_time": wall * 1e3,
                                "cpu_time": cpu * 1e3, "time_unit": "ms", "items_per_second": count / wall,
                                "bytes_per_second": size / wall, "MB": size / 1e6, "cpu_ms": cpu * 1e3})
    print(json.dumps({"benchmarks": results}))


main()
