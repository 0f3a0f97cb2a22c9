"""Five-axis programs of any length for benchmarks: regular lines as a CAM system posts them, and irregular ones."""
import math
import random


def regular(lines, out):
    """One line in five words and a number each, seven digits at most."""
    out.write("%\n(REGULAR)\nG21 G90 G94 G17 G40 G49\nG54\nT1 M6\nS9000 M3\nG0 X0. Y0. Z120. A-35. C0.\nG1 F3000.\n")
    for i in range(lines):
        t = 0.002 * i
        out.write(f"N{i + 1} G1 X{50 * math.cos(t):.4f} Y{50 * math.sin(t):.4f} Z{40 + 5 * math.sin(3 * t):.4f} "
                  f"A{-45 - 30 * math.sin(0.3 * t):.4f} C{math.degrees(t):.4f}\n")
    out.write("M5\nM30\n%\n")


def irregular(lines, out, seed=1):
    """Random words and decimals, inch and mm, increments, comments, empty lines, arcs."""
    draw = random.Random(seed)
    out.write("%\n(IRREGULAR)\nG21 G90 G94 G17\nG0 X10. Y0. Z80. A-35. C0.\nG1 F3000.\n")
    place, inch = {"X": 10.0, "Y": 0.0, "Z": 80.0, "A": -35.0, "C": 0.0}, False
    step = {"X": 0.4, "Y": 0.4, "Z": 0.1, "A": 0.15, "C": 0.4}
    for i in range(lines):
        what = draw.random()
        if what < 0.03:
            out.write(f"(COMMENT {i})\n" if what < 0.02 else "\n")
        elif what < 0.035:
            inch = not inch
            out.write("G20\n" if inch else "G21\n")
        elif what < 0.045 and not inch:
            # A quarter of a small circle.
            x, y = place["X"] + 1, place["Y"] + 1
            out.write(f"G3 X{x:.4f} Y{y:.4f} I0 J1. F800.\nG1\n")
            place["X"], place["Y"] = x, y
        else:
            words = []
            for letter in "XYZAC":
                if draw.random() < 0.6:
                    limit = {"A": (-75, -5), "Z": (20, 100)}.get(letter, (-90, 90))
                    value = place[letter] + draw.uniform(-1, 1) * step[letter]
                    if letter != "C":
                        value = min(max(value, limit[0]), limit[1])
                    digits = draw.choice((2, 3, 4))
                    shown = value / 25.4 if inch and letter in "XYZ" else value
                    text = f"{shown:.{digits + (1 if inch else 0)}f}"
                    place[letter] = float(text) * (25.4 if inch and letter in "XYZ" else 1)
                    words.append(letter + text)
            if not words:
                continue
            if draw.random() < 0.1:
                words.append(f"F{draw.randint(300, 3000)}")
            number = f"N{i} " if draw.random() < 0.5 else ""
            out.write(number + draw.choice((" ", "", "  ")).join(words) + (" (C)" if draw.random() < 0.02 else "") + "\n")
    out.write("M30\n%\n")
