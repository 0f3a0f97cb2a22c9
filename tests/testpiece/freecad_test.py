#!/usr/bin/env python3
"""The STEP of a predicted piece, opened by FreeCAD as a user would.

    freecad_test.py FREECADCMD PROGRAM SOURCE_DIR SCRATCH_DIR

`trunnion predict` writes part.step for the sample piece; FreeCAD must read one valid solid with the piece's cone in it.
Exit status 77 where FREECADCMD is not there: the test is skipped.
"""
import json
import math
import pathlib
import shutil
import subprocess
import sys

LOOK = """
import json, Part
shape = Part.Shape()
shape.read({path!r})
print("found " + json.dumps({{
    "valid": shape.isValid(), "solids": len(shape.Solids), "volume": shape.Volume,
    "angles": [face.Surface.SemiAngle for face in shape.Faces if hasattr(face.Surface, "SemiAngle")]}}))
"""


def main():
    freecad = shutil.which(sys.argv[1])
    if freecad is None:
        print("no FreeCAD here (Debian: freecad-python3); skipped")
        return 77
    program, source, scratch = (pathlib.Path(argument).resolve() for argument in sys.argv[2:5])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    machine = source / "samples/calibrate/machine.toml"
    subprocess.run([program, "identify", "--machine", machine, "--observations",
                    source / "samples/calibrate/replica.csv", "-o", scratch / "model.json"],
                   check=True, capture_output=True)
    subprocess.run([program, "predict", "--machine", machine, "--model", scratch / "model.json", "--piece",
                    source / "samples/predict/piece.toml", "--draws", "0", "-o", scratch / "piece"],
                   check=True, capture_output=True)
    script = LOOK.format(path=str(scratch / "piece/part.step"))
    seen = subprocess.run([freecad, "-c", script], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120,
                          check=False)
    lines = [line for line in seen.stdout.splitlines() if "found {" in line]
    if not lines:
        print("FreeCAD said nothing:", seen.stdout[-500:], seen.stderr[-500:])
        return 1
    found = json.loads(lines[0][lines[0].index("{"):])
    low, high = 40.0, 40 - 20 * math.tan(math.radians(15))
    volume = math.pi * 20 / 3 * (low ** 2 + low * high + high ** 2) + 52 * 52 * 20  # the frustum and its block
    wanted = (found["valid"] and found["solids"] == 1 and abs(found["volume"] / volume - 1) < 1e-9
              and len(found["angles"]) == 1 and abs(found["angles"][0] - math.radians(15)) < 1e-9)
    print(found, "volume wanted", volume)
    return 0 if wanted else 1


if __name__ == "__main__":
    sys.exit(main())
