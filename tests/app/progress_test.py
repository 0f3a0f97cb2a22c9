#!/usr/bin/env python3
"""What long work says of itself: rate and time left on a terminal, nothing elsewhere, and with --verbose what took how long.

    progress_test.py PROGRAM SOURCE_DIR OUTPUT_DIR
"""
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from terminal import seen_on_terminal  # noqa: E402

# Share, rate in its unit and time left, on a line that is written over.
COUNTED = r"\r%s: \d+ %%, [\d.e+]+ %s/s, [\d.]+ (s|min) left"
wrong = []


def wanted(what, holds):
    if not holds:
        wrong.append(what)


def repeated(readings, times, out):
    """Writes to `out` the run in the file `readings` so many times, one after another."""
    rows = readings.read_text().splitlines(keepends=True)
    clock = rows[0].rstrip().split(",").index("time_s")
    run = [row.split(",") for row in rows[1:]]
    length = 1 + max(float(row[clock]) for row in run)
    with open(out, "w", encoding="utf-8") as file:
        file.write(rows[0])
        for k in range(times):
            file.writelines(",".join([*row[:clock], str(float(row[clock]) + length * k), *row[clock + 1:]]) for row in run)


def main():
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    samples = source / "samples"
    on = ["--machine", samples / "calibrate/machine.toml"]
    readings = samples / "calibrate/replica.csv"
    subprocess.run([program, "identify", *on, "--observations", readings, "--quiet", "-o", out / "model.json"], check=True,
                   stdout=subprocess.DEVNULL)
    model = [*on, "--model", out / "model.json"]
    predict = ["predict", *model, "--piece", samples / "predict/piece.toml", "--steps", "720", "-o", out / "piece"]
    rows = (samples / "calibrate/positions.csv").read_text().splitlines(keepends=True)
    many = out / "many.csv"
    many.write_text(rows[0] + "".join(rows[1:]) * 20000)
    part = (samples / "correct/part.ngc").read_text().splitlines(keepends=True)
    at = next(k for k, line in enumerate(part) if line.startswith("N30 "))
    long = out / "long.ngc"
    with open(long, "w", encoding="utf-8") as file:
        file.writelines(part[:at] + [part[at].replace("X0.000", f"X0.0{k % 100}") for k in range(1000000)] + part[at:])

    study = source / "samples/probing/machine-01"
    long_run, long_study, log = out / "long_run.csv", out / "long_study.csv", out / "plan.log"
    repeated(readings, 300, long_run)
    repeated(study / "observations.csv", 8, long_study)
    log.write_text("trunnion-probe-log,1,Middle-size trunnion,0001\ntouch,P,1,0,0,1,1,0,0,1,0,0,3,10.125,20.25,30.5\n")

    long_ones = {
        "identify": (["identify", *on, "--observations", long_run, "-o", out / "long_run.json"], COUNTED % ("identify", "readings")),
        "plan": (["plan", "--machine", study / "machine.toml", "--observations", study / "observations.csv", "--separate",
                  "backlash:A,thermal_drift", "--visits", "60", "-o", out / "long.csv"],
                 COUNTED % ("plan", "visits")),
        "close": (["close", "--machine", study / "machine.toml", "--observations", long_study, "-o", out / "long_close"],
                  r"\rsearch \d+ readings: (readings far off|effect \d of at most \d among \d+ columns), [\d.]+ s"),
        "predict": ([*predict, "--draws", "1000000"], COUNTED % ("draws of uncompensated", "draws")),
        "evaluate": (["evaluate", *model, "--at", many, "-o", out / "many_out.csv"], COUNTED % ("evaluate", "rows")),
        "correct": (["correct", *model, "--job", samples / "correct/job.toml", long, "-o", out / "long_out.ngc", "--report", out / "long.json"],
                    COUNTED % ("(correct|play back)", "MB")),
    }
    for name, (words, pattern) in long_ones.items():
        text = seen_on_terminal([program, *words], until=pattern)
        wanted(f"{name}: no progress on a terminal: {text[-300:]!r}", re.search(pattern, text))
    short = [*predict, "--draws", "100"]
    wanted("quick work wipes a line that it never wrote",
           not re.search(r"\r[^\n]", seen_on_terminal([program, *short], until=r"wrote \S+")))

    quiet = subprocess.run([program, *predict, "--draws", "600", "--quiet", "--verbose"], capture_output=True, text=True, check=True)
    wanted(f"--quiet with --verbose: {quiet.stderr!r}", quiet.stderr == "")
    piped = subprocess.run([program, *predict, "--draws", "600"], capture_output=True, text=True, check=True)
    wanted(f"progress in a pipe: {piped.stderr!r}", "\r" not in piped.stderr and "draws" not in piped.stderr)

    told = {
        "identify": (["identify", *on, "--observations", readings, "-o", out / "again.json"], "identify: 219 readings in"),
        "import": (["import", "probe-log", log, *on, "-o", out / "imported.csv"], r"read plan\.log: 2 lines in"),
        "close": (["close", *on, "--observations", readings, "-o", out / "closed"], "search 219 readings"),
        "plan": (["plan", *on, "--observations", readings, "--separate", "backlash:A", "--visits", "1", "-o", out / "next.csv"],
                 "plan: 1 visits in"),
        "tables": (["tables", *model, "--controller", "linuxcnc", "-o", out / "tables"], "tables for linuxcnc"),
        "predict": (short, "draws of uncompensated: 100 draws in"),
        "evaluate": (["evaluate", *model, "--at", samples / "calibrate/positions.csv", "-o", out / "d.csv"], "evaluate: 36 rows in"),
        "report": (["report", out / "model.json", "-o", out / "page.html"], r"report: 1 files in"),
    }
    for name, (words, what) in told.items():
        done = subprocess.run([program, *map(str, words), "--verbose"], capture_output=True, text=True, check=True)
        wanted(f"{name} --verbose: {done.stderr!r}", re.search("^" + what + r".*\d (s|min)$", done.stderr, re.M))

    print("\n".join(wrong) or "long work says how long")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
