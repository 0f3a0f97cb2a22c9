#!/usr/bin/env python3
"""Makes a fleet out of one calibrated machine: make_fleet.py FOLDER [COUNT]

FOLDER/m01 … each get machine.toml with a serial number of its own, and observations.csv: the readings of samples/calibrate
as they would have been with the location errors of that machine on top, drawn from its number (8 um, 20 urad; one sigma).
"""
import csv
import math
import pathlib
import random
import sys

CALIBRATE = pathlib.Path(__file__).resolve().parent.parent / "calibrate"


def turned(vector, axis, degrees):
    """`vector` turned about X (0) or Z (2)."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    j, k = ((axis + 1) % 3, (axis + 2) % 3)
    out = list(vector)
    out[j], out[k] = c * vector[j] - s * vector[k], s * vector[j] + c * vector[k]
    return out


def pose_error(u, v, a, c):
    """Delta = u + Ad(A) v - Ad(A) Ad(C) (u + v), lengths and angles alike, since both axes pass through the origin."""
    return [[p + q - r for p, q, r in zip(u[k], turned(v[k], 0, a),
                                          turned(turned([x + y for x, y in zip(u[k], v[k])], 2, c), 0, a))]
            for k in (0, 1)]


def main():
    folder, count = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 50
    with (CALIBRATE / "replica.csv").open(newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    machine = (CALIBRATE / "machine.toml").read_text()
    for number in range(1, count + 1):
        rng = random.Random(number)
        um, urad = (lambda: rng.gauss(0, 8e-3)), (lambda: rng.gauss(0, 20e-6))
        u = [[0, um(), um()], [0, urad(), urad()]]  # EY0A EZ0A EB0A EC0A
        v = [[um(), um(), 0], [urad(), urad(), 0]]  # EX0C EY0C EA0C EB0C
        place = folder / f"m{number:02}"
        place.mkdir(parents=True, exist_ok=True)
        (place / "machine.toml").write_text(machine.replace('serial = "0001"', f'serial = "M-{number:02}"'))
        with (place / "observations.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            for row in rows:
                p = [float(row[f"{axis}_mm"]) for axis in "xyz"]
                n = [float(row[f"n{axis}"]) for axis in "xyz"]
                (dx, dy, dz), (da, db, dc) = pose_error(u, v, float(row["A_deg"]), float(row["C_deg"]))
                moved = [dx + db * p[2] - dc * p[1], dy + dc * p[0] - da * p[2], dz + da * p[1] - db * p[0]]
                along = sum(x * y for x, y in zip(n, moved))
                shifted = {f"{axis}_mm": f"{p[k] + n[k] * along:.6f}" for k, axis in enumerate("xyz")}
                writer.writerow({**row, **shifted})


if __name__ == "__main__":
    main()
