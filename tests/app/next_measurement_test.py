"""What `close` cannot tell apart comes with the touches that would: next.csv reads like a plan, and `plan` keeps to its time.

    next_measurement_test.py PROGRAM MACHINE.toml OUTPUT_DIR
"""
import csv
import json
import pathlib
import random
import shutil
import subprocess
import sys


def run(*command, status=0):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    assert done.returncode == status, f"{command}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done


def main():
    program, machine, out = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)

    # A table that sinks by 4 um, at a steady rate: or was it a warm-up that had hardly begun?
    run(program, "plan", "--quiet", "--machine", machine, "-o", out / "plan.csv")
    with open(out / "plan.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    whole_s = float(rows[-1]["time_s"])
    noise = random.Random(1)
    for row in rows:
        normal = [float(row[k]) for k in ("nx", "ny", "nz")]
        moved_mm = -4e-3 * float(row["time_s"]) / whole_s * normal[2] + noise.gauss(0, .175e-3)
        for k, along in zip(("x_mm", "y_mm", "z_mm"), normal):
            row[k] = repr(float(row[k]) + moved_mm * along)
    with open(out / "calibration.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    done = run(program, "close", "--machine", machine, "--observations", out / "calibration.csv", "-o", out / "closed")
    closure = json.loads((out / "closed" / "closure.json").read_text())
    drift = closure["effects"][0]
    assert drift["id"].startswith("thermal_drift") and drift["not_separable_from"], drift
    planned = drift["separate_rows"]
    assert planned["separate"] == [drift["id"], drift["not_separable_from"][0]], planned
    assert len(planned["rows"]) == 3 and planned["file"] == "next.csv", planned
    assert any(p["smallest_after"] < (p["smallest_before"] or 1e9) for p in planned["power"]), planned
    assert "next, as rows in next.csv" in done.stdout, done.stdout
    with open(out / "closed" / "next.csv", newline="") as file:
        further = list(csv.DictReader(file))
    assert len(further) == sum(len(stop["points"]) for stop in planned["rows"])
    assert float(further[0]["time_s"]) > whole_s
    names = {row["point"] for row in rows}
    assert all(row["point"] in names for row in further)
    # What was planned can be probed: as it reads, it joins the calibration.
    run(program, "plan", "--quiet", "--machine", machine, "--observations", out / "closed" / "next.csv", "--separate",
        "backlash:C", "-o", out / "after.csv")

    # The time that a plan may take.
    whole = run(program, "plan", "--machine", machine, "-o", out / "whole.csv").stdout
    short = run(program, "plan", "--machine", machine, "--minutes", "70", "-o", out / "short.csv").stdout
    minutes = [int(text.split("about ")[1].split(" min")[0]) for text in (whole, short)]
    assert minutes[1] <= 70 < minutes[0], minutes
    done = run(program, "plan", "--machine", machine, "--minutes", "10", "-o", out / "none.csv", status=2)
    assert "--minutes 10: a first calibration with 6 touches at a position takes" in done.stderr, done.stderr
    done = run(program, "plan", "--machine", machine, "--observations", out / "calibration.csv", "--separate", "backlash:C",
               "--minutes", "1", "--touches", "12", "-o", out / "none.csv", status=2)
    assert "--minutes 1: no further visit is that short" in done.stderr, done.stderr
    assert not (out / "none.csv").exists()
    done = run(program, "plan", "--machine", machine, "--observations", out / "calibration.csv", "--separate", "backlash:C",
               "--minutes", "4", "-o", out / "four.csv")
    with open(out / "four.csv", newline="") as file:
        times = [float(row["time_s"]) for row in csv.DictReader(file)]
    assert times[-1] - whole_s <= 240, times


main()
