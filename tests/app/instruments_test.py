#!/usr/bin/env python3
"""What R-test, ball-bar, encoders and autocollimator say of the sample machine, against what is true of it.

    instruments_test.py PROGRAM SOURCE_DIR OUTPUT_DIR

- Each instrument by itself has the machine's true errors in its readings once, not minus once and not scaled.
- The maps from the R-test and those from all of them are true within their own standard uncertainties.
- What a ball-bar alone does not determine is said not to be seen, in words and in the model, never as a zero.
"""
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys

INSTRUMENTS = {"R-test": 0.02, "ball-bar": 0.1, "encoder of A": 0.1, "encoder of C": 0.5, "autocollimator": 0.4}
SIGMAS = 3.5
POINT_MM = (80, -40, 100)  # as far from R's origin as parts are
wrong = []


def wanted(what, holds):
    if not holds:
        wrong.append(what)


def table(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(row for row in file if not row.startswith("#")))


def write(path, rows):
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def true_model(truth, machine):
    """The true errors at the nodes as a model file."""
    tilts = sorted({float(row["A_deg"]) for row in truth})
    turns = sorted({float(row["C_deg"]) for row in truth})
    at = {(float(row["A_deg"]), float(row["C_deg"])): row for row in truth}
    values = {}
    for letter in "XYZABC":
        unit = "um" if letter in "XYZ" else "urad"
        tilt, turn = f"E{letter}A", f"E{letter}C"
        values[tilt] = {"unit": unit, "data": [float(at[a, turns[0]][f"{tilt}_{unit}"]) for a in tilts]}
        values[turn] = {"unit": unit, "data": [[float(at[a, c][f"{turn}_{unit}"]) for c in turns] for a in tilts]}
    return {"format": "trunnion-model", "version": 1, "machine": machine, "reference_pose_deg": {"A": 0, "C": 0},
            "effects": [{"id": "rotary_error_map", "origin": "machine", "grid_deg": {"A": tilts, "C": turns}, "values": values}]}


def misses(truth, rows):
    """Of each component of the deviation at POINT_MM, how many standard uncertainties it is off."""
    off = []
    for true, row in zip(truth, rows):
        if float(true["A_deg"]) == 0 and float(true["C_deg"]) == 0:
            continue
        length = [float(true[f"D{axis}_um"]) for axis in "xyz"]
        turn = [1e-3 * float(true[f"D{axis}_urad"]) for axis in "abc"]  # um on a mm
        x, y, z = POINT_MM
        moved = [turn[1] * z - turn[2] * y, turn[2] * x - turn[0] * z, turn[0] * y - turn[1] * x]
        off += [(float(row[f"d{axis}_um"]) - length[k] - moved[k]) / float(row[f"sd{axis}_um"]) for k, axis in enumerate("xyz")]
    return off


def main():
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    calibrate = source / "samples/calibrate"
    machine = ["--machine", calibrate / "machine.toml"]
    truth = table(calibrate / "truth.csv")
    readings = table(source / "samples/instruments/instruments.csv")

    def run(*words):
        return subprocess.run([program, *map(str, words), "--quiet"], capture_output=True, text=True, check=True).stdout

    files = {name: out / f"{name.replace(' ', '_')}.csv" for name in INSTRUMENTS}
    for name, file in files.items():
        write(file, [row for row in readings if row["artifact"] == name])
    wanted("rows of an unknown instrument", {row["artifact"] for row in readings} == set(INSTRUMENTS))
    run("identify", *machine, "--observations", files["R-test"], "-o", out / "r-test.json")
    identity = json.loads((out / "r-test.json").read_text())["machine"]
    (out / "true.json").write_text(json.dumps(true_model(truth, identity)))

    for name, file in files.items():
        checks = json.loads(run("doctor", *machine, "--observations", file, "--model", out / "true.json", "--json"))["checks"]
        said = next(check for check in checks if check["id"] == "model.sign")["found"]
        times, std = (float(word) for word in said.split("in the readings ")[1].split(" times")[0].split(" +- "))
        wanted(f"{name}: the true errors are in its readings {times} +- {std} times", abs(times - 1) < SIGMAS * std)
        wanted(f"{name}: known to {std} only", std < INSTRUMENTS[name])

    run("identify", *machine, "--observations", source / "samples/instruments/instruments.csv", "-o", out / "all.json")
    write(out / "at.csv", [{"A_deg": row["A_deg"], "C_deg": row["C_deg"], **dict(zip(("x_mm", "y_mm", "z_mm"), POINT_MM))}
                           for row in truth])
    spread = {}
    for name in ("r-test", "all"):
        run("evaluate", *machine, "--model", out / f"{name}.json", "--at", out / "at.csv", "-o", out / f"{name}.csv")
        rows = table(out / f"{name}.csv")
        off = misses(truth, rows)
        rms = math.sqrt(sum(v * v for v in off) / len(off))
        wanted(f"{name}: off by {rms} standard uncertainties rms", 0.6 < rms < 1.4)
        wanted(f"{name}: off by {max(map(abs, off))} standard uncertainties", max(map(abs, off)) < 4)
        spread[name] = sum(float(row["sd_um"]) for row in rows)
    wanted(f"more instruments know no more: {spread}", spread["all"] < spread["r-test"])

    said = run("identify", *machine, "--observations", files["ball-bar"], "-o", out / "ball-bar.json")
    wanted("a ball-bar alone: " + said.splitlines()[0], "determine none of the errors" in said and "as declared" not in said)
    errors = json.loads((out / "ball-bar.json").read_text())["fit"]["errors"]
    for name, found in errors.items():
        wanted(f"{name} of a ball-bar alone: {found}", found["largest"] is None and found["nodes_unseen"] == found["nodes"])
        wanted(f"{name} of a ball-bar alone, in words", any(line.split()[:1] == [name] and line.endswith("not seen")
                                                           for line in said.splitlines()))
    run("report", out / "ball-bar.json", "-o", out / "report.html")
    page = (out / "report.html").read_text(encoding="utf-8")
    wanted("the page of a ball-bar alone", "determine none of the errors" in page and "not seen" in page)
    print("\n".join(wrong) or "the instruments say what is true")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
