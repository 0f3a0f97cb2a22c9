#!/usr/bin/env python3
"""Every command tells its summary to machines, and is quiet when asked to be.

    json_test.py PROGRAM SOURCE_DIR OUTPUT_DIR

Runs each command of the option tree with --json --quiet: standard output is one JSON text, standard error is empty; with
--quiet alone standard error is empty as well. A command that this test does not run is a finding.
"""
import csv
import json
import pathlib
import shutil
import subprocess
import sys

from help_test import commands_below, helped


def leaves(program):
    """Every command that has none below it, as its words."""
    paths, found = [[]], []
    while paths:
        path = paths.pop()
        below = commands_below(helped(program, path))
        paths += [[*path, name] for name in below]
        if not below:
            found.append(" ".join(path))
    return found


def probe_log(plan, log):
    """The log of a probing program that met every face where the plan has it."""
    with open(plan, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    keys = "point artifact A_deg C_deg A_dir C_dir repeat time_s nx ny nz".split()
    lines = ["trunnion-probe-log,1,Middle-size trunnion,0001"]
    lines += [",".join(["touch", *(row[k] for k in keys), "0", row["x_mm"], row["y_mm"], row["z_mm"]]) for row in rows]
    log.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    samples = source / "samples"
    machine, readings = samples / "calibrate/machine.toml", samples / "calibrate/replica.csv"
    calibration = samples / "close/calibration.csv"
    on = ["--machine", machine]
    model = [*on, "--model", out / "model.json"]
    store = ["--store", out / "store.db"]
    runs = [
        ["identify", *on, "--observations", readings, "-o", out / "model.json"],
        ["identify", *on, "--observations", calibration, "-o", out / "later.json"],
        ["doctor", *on],
        ["close", *on, "--observations", readings, "-o", out / "closed"],
        ["plan", *on, "--nc", "linuxcnc", "-o", out / "plan.csv"],
        ["import probe-log", out / "plan.log", *on, "-o", out / "imported.csv"],
        ["evaluate", *model, "--at", samples / "calibrate/positions.csv", "-o", out / "deviations.csv"],
        ["tables", *model, "--controller", "linuxcnc", "-o", out / "tables"],
        ["correct", *model, "--job", samples / "correct/job.toml", samples / "correct/part.ngc", "-o", out / "part.ngc"],
        ["predict", *model, "--piece", samples / "predict/piece.toml", "-o", out / "piece"],
        ["report", out / "closed", "-o", out / "report.html"],
        ["history add", *store, *model, "--date", "2026-01-15"],
        ["history add", *store, *on, "--model", out / "later.json", "--date", "2026-03-15"],
        ["history list", *store],
        ["history show", "1", *store],
        ["history compare", "1", "2", *store],
        ["history drift", *store],
        ["history trend", *store],
        ["history prior", *store, "--date", "2026-07-01", "-o", out / "prior.json"],
        ["batch", out / "plan.toml", "-o", out / "fleet"],
        ["completion", "bash"],
    ]
    (out / "machines/one").mkdir(parents=True)
    shutil.copyfile(machine, out / "machines/one/machine.toml")
    shutil.copyfile(readings, out / "machines/one/observations.csv")
    (out / "plan.toml").write_text('format = "trunnion-batch"\nversion = 1\nseed = 1\n[machines]\nfolder = "machines"\n'
                                   '[tables]\ncontrollers = ["linuxcnc"]\n', encoding="utf-8")
    wrong = [f"{name}: is not run here" for name in leaves(program) if name not in {run[0] for run in runs}]
    for run in runs:
        if run[0] == "import probe-log":
            probe_log(out / "plan.csv", out / "plan.log")
        words = [*run[0].split(), *map(str, run[1:])]
        for talk in (["--json", "--quiet"], ["--quiet"]):
            done = subprocess.run([program, *words, *talk], capture_output=True, text=True, check=False, cwd=source)
            if done.returncode != 0:
                wrong.append(f"{run[0]}: exit status {done.returncode}: {done.stderr.strip()}")
            elif done.stderr:
                wrong.append(f"{run[0]} {' '.join(talk)}: not quiet: {done.stderr.strip()}")
            elif "--json" in talk:
                try:
                    json.loads(done.stdout)
                except ValueError as error:
                    wrong.append(f"{run[0]}: no JSON: {error}")
    print("\n".join(wrong) or f"{len(runs)} commands tell their summary")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
