#!/usr/bin/env python3
"""How many instructions a line of a five-axis program costs, counted by valgrind's callgrind: seconds depend on the day,
these do not.

    instructions_test.py PROGRAM SOURCE_DIR

Two programs of different length are corrected on one thread; the difference leaves out what happens once (files, baking the
map). Skipped (77) where valgrind is not installed. Limits are 3 % above what was counted when they were written, for the
preset test.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

LIMITS = {"regular": 9650, "irregular": 8420}
SHORT, LONG = 40_000, 55_000  # long enough for the map to be baked


def instructions(program, source, folder, kind, lines):
    sys.path.insert(0, str(source / "tests" / "bench"))
    import nc_programs
    with open(folder / "in.ngc", "w", encoding="ascii") as out:
        getattr(nc_programs, kind)(lines, out)
    count = sum(1 for _ in open(folder / "in.ngc", "rb"))
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=cg.out", program, "correct", "--machine",
               source / "machines/seed-trunnion.toml", "--model", source / "tests/golden/shared/model.json", "in.ngc",
               "-o", "out.ngc", "--quiet", "--threads", "1"]
    run = subprocess.run([str(c) for c in command], cwd=folder, capture_output=True, text=True, check=False)
    found = re.search(r"Collected : (\d+)|I\s+refs:\s+([\d,]+)", run.stderr)
    if run.returncode != 0 or not found:
        sys.exit(f"callgrind: exit status {run.returncode}: {run.stderr[-500:]}")
    return count, int((found.group(1) or found.group(2)).replace(",", ""))


def main():
    program, source = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    if not shutil.which("valgrind"):
        print("valgrind is not installed")
        sys.exit(77)
    failed = False
    with tempfile.TemporaryDirectory() as name:
        for kind, limit in LIMITS.items():
            short = instructions(program, source, pathlib.Path(name), kind, SHORT)
            long = instructions(program, source, pathlib.Path(name), kind, LONG)
            a_line = (long[1] - short[1]) / (long[0] - short[0])
            verdict = "ok" if a_line <= limit else "TOO MANY"
            print(f"{kind}: {a_line:.0f} instructions a line, at most {limit}: {verdict}")
            failed |= a_line > limit
    sys.exit(1 if failed else 0)


main()
