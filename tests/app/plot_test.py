#!/usr/bin/env python3
"""The plot in the terminal shows the map that was written.

    plot_test.py PROGRAM SOURCE_DIR OUTPUT_DIR

Runs `identify` on the sample calibration, reads the braille back into dots, and compares the bars at the nodes, and the curve
that passes through them, with the values and standard uncertainties of the model file.
"""
import json
import pathlib
import re
import subprocess
import sys

WIDE, HIGH = 120, 32
BITS = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]]


def dots_of(lines):
    """Set of (x, y) of the dots that stand, y from the top."""
    found = set()
    for r, line in enumerate(lines):
        for c, char in enumerate(re.search("[\u2800-\u28ff]+", line)[0]):
            found |= {(2 * c + i, 4 * r + j) for i in range(2) for j in range(4) if (ord(char) - 0x2800) & BITS[i][j]}
    return found


def main():
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    out.mkdir(parents=True, exist_ok=True)
    sample, model_file = source / "samples/calibrate", out / "model.json"
    text = subprocess.run([program, "identify", "--quiet", "--machine", sample / "machine.toml", "--observations",
                           sample / "replica.csv", "-o", model_file, "--verbose"], capture_output=True, text=True, check=True).stdout
    lines = text.splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("The largest, "))
    symbol, unit, tilt = re.match(r"The largest, (E[XYZABC]C) in (\w+), over C at A (\S+)", lines[start]).groups()
    plot = lines[start + 1:start + 9]
    dots = dots_of(plot)
    top, bottom = (float(plot[k].split()[0]) for k in (0, -1))  # to three digits
    grid = json.loads(model_file.read_text(encoding="utf-8"))["effects"][0]
    row = [float(a) for a in grid["grid_deg"]["A"]].index(float(tilt))
    values, stds = grid["values"][symbol]["data"][row], grid["std"][symbol]["data"][row]
    wrong = []
    for c, value, std in zip(grid["grid_deg"]["C"], values, stds):
        x = round(c / 360 * (WIDE - 1))
        for what, y in [("value", value), ("upper end", value + 2 * std), ("lower end", value - 2 * std)]:
            wanted = (top - y) / (top - bottom) * (HIGH - 1)
            if not any((x, round(wanted) + off) in dots for off in (-1, 0, 1)):
                wrong.append(f"{symbol} at C {c}: {what} {y:.3f} {unit}: no dot near {x}, {wanted:.1f}")
    for x in range(WIDE):
        if not any(dx == x for dx, _ in dots):
            wrong.append(f"column {x} is empty: the curve is broken")
    nodes = text[text.index("At every node"):]
    if f"{values[0]:.2f} +- {stds[0]:.2f}" not in nodes:
        wrong.append(f"--verbose does not list {symbol} at the first node of the row, {values[0]:.2f} +- {stds[0]:.2f}")
    print("\n".join(wrong) or f"{symbol} is drawn as it was found at {len(values)} nodes")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
