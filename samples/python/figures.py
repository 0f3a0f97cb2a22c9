#!/usr/bin/env python3
"""Draws the rotary errors of the replica as the source paper shows those of its machine.

    figures.py [OUTPUT_FOLDER]

Ibaraki, Iritani & Matsushita (2010), figures 6 to 8: the errors of A over A, the angular errors of C, and the linear errors of
C over C with one curve for each A. Bars are two standard uncertainties; crosses are the errors that the simulated machine was
given.
"""
import csv
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy as np

import trunnion

DATA = pathlib.Path(__file__).resolve().parent.parent / "calibrate"


def truth_of(symbol, unit, a, c):
    """What the machine was given at the stations: shape (n_A,) or (n_A, n_C)."""
    with open(DATA / "truth.csv", encoding="utf-8") as file:
        given = {(float(row["A_deg"]), float(row["C_deg"])): float(row[f"{symbol}_{unit}"]) for row in csv.DictReader(file)}
    return np.array([[given[x, y] for y in c] for x in a]) if symbol[2] == "C" else np.array([given[x, c[0]] for x in a])


def panel(axes, model, symbol):
    a, c = model.tilt_deg, model.turn_deg
    unit = "um" if symbol[1] in "XYZ" else "urad"
    error, std = model.error(symbol), model.std(symbol)
    given = truth_of(symbol, unit, a, c)
    if error.ndim == 1:
        axes.errorbar(a, error, 2 * std, fmt="o-", capsize=3)
        axes.plot(a, given, "kx", label="given")
        axes.set_xlabel("A, deg")
    else:
        round_trip = np.append(c, c[0] + 360)  # periodic: the end is the beginning again
        for i, tilt in enumerate(a):
            closed = [np.append(row[i], row[i][0]) for row in (error, std, given)]
            curve = axes.errorbar(round_trip, closed[0], 2 * closed[1], fmt="o-", capsize=3, label=f"A = {tilt:g} deg")
            axes.plot(round_trip, closed[2], "x", color=curve[0].get_color())
        axes.set_xlabel("C, deg")
        axes.set_xticks(np.arange(0, 361, 60))
    axes.set_ylabel(f"{symbol}, {unit}")
    axes.grid(True)


def draw(path, title, model, symbols):
    figure, all_axes = plt.subplots(len(symbols), 1, figsize=(7, 2.4 * len(symbols)), sharex=True, layout="constrained")
    for axes, symbol in zip(all_axes, symbols):
        panel(axes, model, symbol)
        axes.label_outer()
    all_axes[0].legend(loc="best", fontsize="small")
    figure.suptitle(title)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main():
    out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    out.mkdir(parents=True, exist_ok=True)
    machine = trunnion.Machine(DATA / "machine.toml")
    model = trunnion.identify(machine, trunnion.Observations(DATA / "replica.csv", machine)).model
    draw(out / "figure_6.png", "Errors of the A axis", model, ("EXA", "EYA", "EZA", "EAA", "EBA", "ECA"))
    draw(out / "figure_7.png", "Angular errors of the C axis", model, ("EAC", "EBC", "ECC"))
    draw(out / "figure_8.png", "Linear errors of the C axis", model, ("EXC", "EYC", "EZC"))


if __name__ == "__main__":
    main()
