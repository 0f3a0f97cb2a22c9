#!/usr/bin/env python3
"""trunnion doctor, as people and scripts use it.

    doctor_test.py PROGRAM SOURCE_DIR OUTPUT_DIR

The sign test is written for every dialect and read back by `correct`; its form is filled in as a right and as a reversed
machine would have it; blanks are refused; the two poses for a model's sign are touched in numbers; colours stand on a
terminal alone, and not with NO_COLOR.
"""
import csv
import json
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from terminal import seen_on_terminal  # noqa: E402

wrong = []


def wanted(what, holds):
    if not holds:
        wrong.append(what)


def run(program, *words, status=0):
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
    wanted(f"{words}: exit status {done.returncode}, {status} is wanted\n{done.stdout}{done.stderr}", done.returncode == status)
    return done


def outcomes(done):
    return {check["id"]: check["outcome"] for check in json.loads(done.stdout)["checks"]}


def fill(form, out, mirror):
    """The form as a machine fills it whose C turns the other way where `mirror` is -1: X and Y of the mark exchanged."""
    rows = form.read_text(encoding="utf-8").splitlines()
    comments = [row for row in rows if "stop " in row]
    places = [[float(v) for v in row.split("X Y Z ")[1].split(",")] for row in comments]
    if mirror < 0:  # the mark at 70, 70 turned by -30 instead of +30 deg: mirrored at the diagonal
        places[1][0], places[1][1] = places[1][1], places[1][0]
    filled = iter(places)
    text = [row if row.startswith("#") or row.startswith("A_deg") else
            row.rstrip(",") + "," + ",".join(f"{v:.1f}" for v in next(filled)) for row in rows]
    out.write_text("\n".join(text) + "\n", encoding="utf-8")


def main():
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    sample = source / "samples/calibrate"
    machine, readings, model = sample / "machine.toml", sample / "replica.csv", out / "model.json"
    run(program, "identify", "--machine", machine, "--observations", readings, "-o", model)

    # Programs of the sign test: read by our own readers of the four dialects, which refuse what they do not know.
    for dialect, ending in [("linuxcnc", "ngc"), ("fanuc", "nc"), ("sinumerik", "mpf"), ("heidenhain", "h")]:
        folder = out / dialect
        run(program, "doctor", "--machine", machine, "--dialect", dialect, "-o", folder)
        text = folder / f"sign_test.{ending}"
        run(program, "correct", "--machine", machine, "--model", model, "--dialect", dialect, text, "-o", folder / "again")
        wanted(f"{dialect}: the program moves a linear axis",
               not any(word[0] in "XYZ" and word[1:2] in "+-0123456789" and len(word) > 1
                       for line in text.read_text(encoding="utf-8").splitlines() if not line.lstrip("0123456789 ").startswith(("(", ";"))
                       for word in line.split()))

    # A control without a dialect of ours gets plain words, marked as a draft: the moves of the rotary axes, five stops.
    plain = out / "aerotech.toml"
    plain.write_text(machine.read_text(encoding="utf-8").replace('controller = "linuxcnc"', 'controller = "aerotech"'),
                     encoding="utf-8")
    said = run(program, "doctor", "--machine", plain, "-o", out / "plain")
    words = (out / "plain/sign_test.DRAFT.nc").read_text(encoding="utf-8").split("\n")
    wanted(f"a draft in plain words: {words}", [line.split()[0] for line in words if line] ==
           ["G90", "M0", "G0", "M0", "G0", "M0", "G0", "M0", "G0", "M0", "G0", "M30"])
    wanted("the draft is not said to be one: " + said.stderr, "read it before it is run" in said.stderr)

    form = out / "linuxcnc/sign_test.csv"
    blank = run(program, "doctor", "--machine", machine, "--form", form, status=2)
    wanted("a blank form: " + blank.stderr, "left blank" in blank.stderr and "sign_test.csv:" in blank.stderr)
    for mirror, status in [(1, 0), (-1, 1)]:
        fill(form, out / "filled.csv", mirror)
        found = outcomes(run(program, "doctor", "--machine", machine, "--form", out / "filled.csv", "--json", status=status))
        wanted(f"C {mirror}: {found}", found["sign_test.C"] == ("passed" if mirror > 0 else "failed"))
        wanted(f"A beside C {mirror}: {found}", found["sign_test.A"] == "passed")

    # Two poses: the plan's touches moved by what the model says of them, and by its opposite.
    folder = out / "model"
    run(program, "doctor", "--machine", machine, "--observations", readings, "--model", model, "-o", folder)
    wanted("no two_poses.ngc", (folder / "two_poses.ngc").exists())
    with open(folder / "two_poses.csv", encoding="utf-8") as file:
        plan = list(csv.DictReader(file))
    run(program, "evaluate", "--machine", machine, "--model", model, "--at", folder / "two_poses.csv", "-o", out / "at.csv")
    with open(out / "at.csv", encoding="utf-8") as file:
        deviations = list(csv.DictReader(file))
    largest = 0
    for sign, status in [(1, 0), (-1, 1)]:
        with open(out / "touched.csv", "w", encoding="utf-8") as file:
            writer = csv.DictWriter(file, plan[0].keys())
            writer.writeheader()
            for row, deviation in zip(plan, deviations):
                n = [float(row[k]) for k in ("nx", "ny", "nz")]
                along = sum(n[k] * float(deviation[f"d{'xyz'[k]}_um"]) for k in range(3))
                largest = max(largest, abs(along))
                moved = {f"{'xyz'[k]}_mm": repr(float(row[f"{'xyz'[k]}_mm"]) + sign * 1e-3 * along * n[k]) for k in range(3)}
                writer.writerow({**row, **moved})
        found = outcomes(run(program, "doctor", "--machine", machine, "--observations", out / "touched.csv", "--model", model,
                             "--json", status=status))
        wanted(f"sign {sign}: {found}", found["model.sign"] == ("passed" if sign > 0 else "failed"))
    wanted(f"the two poses are worth {largest} um only", largest > 3)

    words = ["doctor", "--machine", machine]
    wanted("no colour on a terminal", "\x1b[" in seen_on_terminal([program, *words], "stdout", environment={"NO_COLOR": ""}))
    wanted("colour in spite of NO_COLOR", "\x1b[" not in seen_on_terminal([program, *words], "stdout", environment={"NO_COLOR": "1"}))
    wanted("colour in a pipe", "\x1b[" not in run(program, *words).stdout)

    print("\n".join(wrong) or "doctor does what it says")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
