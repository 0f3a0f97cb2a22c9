#!/usr/bin/env python3
"""LinuxCNC's own interpreter runs the sign test of every machine file as its form says.

    sign_test_rs274_test.py PROGRAM SOURCE_DIR OUTPUT_DIR

rs274 reads the program that `doctor` writes: it stops at each row of the form, at that row's angles, comes back to zero,
and commands no linear axis. Exit status 77 where there is no rs274.
"""
import csv
import pathlib
import re
import shutil
import subprocess
import sys

TRAVERSE = re.compile(r"STRAIGHT_TRAVERSE\(([^)]*)\)")


def stops_of(lines):
    """X Y Z A B C at each stop, and at the end."""
    at, stops = [0.0] * 6, []
    for line in lines:
        if "PROGRAM_STOP" in line or "PROGRAM_END" in line:
            stops.append(list(at))
        moved = TRAVERSE.search(line)
        if moved:
            at = [float(word) for word in moved[1].split(",")[:6]]
        elif "STRAIGHT_FEED" in line or "ARC_FEED" in line:
            stops.append([line])
    return stops


def main():
    if shutil.which("rs274") is None:
        print("rs274 is not installed")
        return 77
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out, ignore_errors=True)
    wrong = []
    machines = sorted((source / "machines").glob("*.toml"))
    for machine in machines:
        folder = out / machine.stem
        folder.mkdir(parents=True)
        subprocess.run([program, "doctor", "--machine", machine, "--dialect", "linuxcnc", "--quiet", "-o", folder], check=True,
                       stdout=subprocess.DEVNULL)
        (folder / "vars.var").write_text("")
        (folder / "tool.tbl").write_text("T1 P1 D10 Z0\n")
        read = subprocess.run(["rs274", "-t", "tool.tbl", "-v", "vars.var", "-g", "sign_test.ngc"], cwd=folder, text=True,
                              capture_output=True, timeout=60, env={"HOME": str(folder), "PATH": "/usr/bin:/bin"}, check=False)
        with open(folder / "sign_test.csv", encoding="utf-8") as file:
            form = list(csv.DictReader(row for row in file if not row.startswith("#")))
        tilt = "A" if "A_deg" in form[0] else "B"
        wanted = [(0, 0)] + [(float(row[f"{tilt}_deg"]), float(row["C_deg"])) for row in form] + [(0, 0)]
        stops = stops_of(read.stdout.splitlines())
        found = [(stop[3 if tilt == "A" else 4], stop[5]) for stop in stops if len(stop) == 6]
        if found != wanted:
            wrong.append(f"{machine.name}: stops at {found}, the form has {wanted} {read.stderr}")
        if any(stop[:3] != [0, 0, 0] for stop in stops):
            wrong.append(f"{machine.name}: a linear axis moves, or one at feed")
    print("\n".join(wrong) or f"{len(machines)} sign tests run as their forms say")
    return 1 if wrong or len(machines) < 10 else 0


if __name__ == "__main__":
    sys.exit(main())
