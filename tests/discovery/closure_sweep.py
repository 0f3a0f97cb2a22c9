"""Closes the loop on thousands of virtual machines and writes what came of it into docs/closing-the-loop.md.

    closure_sweep.py --program closure_sweep [--draws 100] [--nulls 400] [--jobs N] [--rows FILE] [--page PAGE]
    closure_sweep.py --again FILE [--page PAGE]        the tables of the rows that an earlier run kept

--rows names the file to which rows are added as they come; a run that was stopped goes on from it.

Exit status 1 where fewer than 95 % of the undeclared effects that can be seen are named, more than 5 % of what is
accepted is wrong, or more than 3 % of the machines that lack nothing are said to lack something; alike for pieces."""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import time

BATCH = 20  # closures that one process does
BEGIN, END = "<!-- sweep: begin -->", "<!-- sweep: end -->"
FOLDS, VERIFIED = "three_passes", "three_passes_verified"
PAIRS = ["squareness:XY+backlash:C", "linear_scale:X+artifact_slip:2", "thermal_drift+probe_lobing:4",
         "straightness:EZX+backlash:A"]
PIECES = {"alone": "a cone that leans 30 deg, alone", "with_probing": "the same with a probing in which C never turns back",
          "upright": "a cone that leans 10 deg, alone: C never turns back"}
HIDDEN_BY_CHIPS = ["squareness:XZ", "backlash:C", "artifact_expansion", "linear_periodic:Y"]


def tasks(options, ids, inventions):
    """(kind, measured, name, how many)"""
    for name in ids:
        for measured in (FOLDS, VERIFIED):
            yield "effect", measured, name, options.draws
    for name in PAIRS:
        yield "two", FOLDS, name, options.draws // 2
    for name in HIDDEN_BY_CHIPS:
        yield "chips", FOLDS, name, options.draws // 2
    for name in inventions:
        for measured in (FOLDS, VERIFIED):
            yield "invention", measured, name, max(4, options.draws // 5)
    each = options.nulls // 8
    for measured in ("calibration", "verified", FOLDS, VERIFIED):
        yield "null", measured, "", each
        yield "chips", measured, "", each // 2
        yield "student", measured, "", each // 2
    for measured in (FOLDS, VERIFIED):
        yield "harmonics", measured, "", each
    for measured in PIECES:
        yield "piece", measured, "", options.draws
        yield "piece_null", measured, "", options.nulls // 4


def run(program, kind, measured, name, first, count):
    command = [program, kind, measured, str(first), str(count)] + ([name] if name else [])
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: {done.stderr.strip()}")
    return [dict(json.loads(line), measured=measured) for line in done.stdout.splitlines()]


def share(part, whole):
    return "–" if whole == 0 else f"{100 * part / whole:.0f} %"


def effect_table(rows):
    by = collections.defaultdict(list)
    for r in rows:
        if r["kind"] == "effect":
            by[r["name"], r["measured"]].append(r)
    lines = ["| undeclared effect | folds of three passes: named | wrong | verification kept apart: named | wrong |",
             "| --- | --- | --- | --- | --- |"]
    total = collections.Counter()
    for name in sorted({n for n, _ in by}):
        cells = []
        for measured in (FOLDS, VERIFIED):
            seen = [r for r in by[name, measured] if r["visible"]]
            right = sum(all(r["named"]) for r in seen)
            wrong = sum(bool(r["accepted"]) and not all(r["named"]) for r in seen)
            if len(seen) * 2 < len(by[name, measured]):
                cells += ["cannot be seen", "–"]
                continue
            total["seen"] += len(seen)
            total["right"] += right
            total["wrong"] += wrong
            cells += [f"{right} of {len(seen)}", str(wrong)]
        lines.append(f"| `{name}` | " + " | ".join(cells) + " |")
    lines.append(f"| **all** | **{total['right']} of {total['seen']} named, {share(total['right'], total['seen'])}; "
                 f"{total['wrong']} wrong, {share(total['wrong'], total['seen'])}** | | | |")
    return lines, total


def null_table(rows):
    names = {"null": "2 to 4 harmonics in C", "chips": "2 % chips", "student": "Student-t noise, 5 degrees of freedom",
             "harmonics": "4 harmonics in C, all changing with A"}
    plans = {"calibration": "one pass", "verified": "one pass, verification", FOLDS: "three passes",
             VERIFIED: "three passes, verification"}
    lines = ["| nothing missing | " + " | ".join(plans.values()) + " |", "| --- |" + " --- |" * len(plans)]
    total = collections.Counter()
    for kind, title in names.items():
        cells = []
        for measured in plans:
            found = [r for r in rows if r["kind"] == kind and r["measured"] == measured and not r["name"]]
            alarms = sum(bool(r["accepted"]) for r in found)
            total["machines"] += len(found)
            total["alarms"] += alarms
            cells.append(f"{alarms} of {len(found)}" if found else "–")
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    lines.append(f"| **all** | **{total['alarms']} false alarms of {total['machines']}, "
                 f"{share(total['alarms'], total['machines'])}** | | | |")
    return lines, total


def invention_table(rows):
    lines = ["| invented effect | accepted most often | residual ≤ 1.15 sigma | kept-back error falls | true error of the "
             "corrected machine, after / before: median | worst |", "| --- | --- | --- | --- | --- | --- |"]
    for name in sorted({r["name"] for r in rows if r["kind"] == "invention"}):
        found = [r for r in rows if r["kind"] == "invention" and r["name"] == name]
        common = collections.Counter(", ".join(r["accepted"]) or "nothing" for r in found).most_common(1)[0][0]
        ratios = sorted(r["map_after_um"] / r["map_before_um"] for r in found)
        lines.append(f"| {name} | {common} | {sum(r['residual_um'] <= 1.15 * .175 for r in found)} of {len(found)} | "
                     f"{sum(r['holdout_after_um'] < r['holdout_before_um'] for r in found)} | "
                     f"{ratios[len(ratios) // 2]:.2f} | {ratios[-1]:.2f} |")
    return lines


def other_table(rows):
    lines = ["| | both named, nothing else | wrong |", "| --- | --- | --- |"]
    for kind, name in [("two", n) for n in PAIRS] + [("chips", n) for n in HIDDEN_BY_CHIPS]:
        found = [r for r in rows if r["kind"] == kind and r["name"] == name and r["visible"]]
        right = sum(r["right"] for r in found)
        wrong = sum(bool(r["accepted"]) and not any(r["named"]) for r in found)
        title = name.replace("+", "` and `")
        lines.append(f"| `{title}`{' with 2 % chips' if kind == 'chips' else ''} | {right} of {len(found)} | {wrong} |")
    return lines


def piece_table(rows):
    lines = ["| cut with an undeclared backlash of C, 30 urad | named | said to be untestable | roundness before → after, um: "
             "median | false alarms where nothing is missing |", "| --- | --- | --- | --- | --- |"]
    total = collections.Counter()
    for measured, title in PIECES.items():
        cut = [r for r in rows if r["kind"] == "piece" and r["measured"] == measured]
        sound = [r for r in rows if r["kind"] == "piece_null" and r["measured"] == measured]
        if not cut or not sound:
            continue
        before, after = (sorted(r[key] for r in cut)[len(cut) // 2] for key in ("roundness_before_um", "roundness_after_um"))
        alarms = sum(bool(r["accepted"]) for r in sound)
        total["machines"] += len(sound)
        total["alarms"] += alarms
        if measured != "upright":
            total["cut"] += len(cut)
            total["named"] += sum(r["named"] for r in cut)
        lines.append(f"| {title} | {sum(r['named'] for r in cut)} of {len(cut)} | {sum(r['untestable'] for r in cut)} | "
                     f"{before:.2f} → {after:.2f} | {alarms} of {len(sound)} |")
    return lines, total


def all_rows(options):
    """What the file of rows has is not done again: a sweep that was stopped goes on."""
    names = json.loads(subprocess.run([options.program, "list"], capture_output=True, text=True, check=True).stdout)
    rows = [json.loads(line) for line in options.rows.read_text().splitlines()] if options.rows and options.rows.exists() else []
    done = {(r["kind"], r["measured"], r["name"], r["seed"]) for r in rows}
    pieces = []
    for kind, measured, name, count in tasks(options, names["effects"], names["inventions"]):
        missing = [seed for seed in range(count) if (kind, measured, name, seed) not in done]
        first = missing[0] if missing else count
        pieces += [(kind, measured, name, at, min(BATCH, count - at)) for at in range(first, count, BATCH)]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for finished in concurrent.futures.as_completed(pool.submit(run, options.program, *piece) for piece in pieces):
            rows += finished.result()
            if options.rows:
                with open(options.rows, "a", encoding="utf-8") as file:
                    file.write("".join(json.dumps(r) + "\n" for r in finished.result()))
    return sorted(rows, key=lambda r: (r["kind"], r["measured"], r["name"], r["seed"]))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program")
    parser.add_argument("--again", type=pathlib.Path)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--nulls", type=int, default=400)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--rows", type=pathlib.Path)
    parser.add_argument("--page", type=pathlib.Path)
    options = parser.parse_args()
    started = time.time()
    if options.again:
        rows = [json.loads(line) for line in options.again.read_text().splitlines()]
    else:
        rows = all_rows(options)
    effects, named = effect_table(rows)
    nulls, alarms = null_table(rows)
    pieces, of_pieces = piece_table(rows)
    draws = max(collections.Counter((r["name"], r["measured"]) for r in rows if r["kind"] == "effect").values())
    cpu = sum(r["cpu_s"] for r in rows)
    text = "\n".join([
        f"{len(rows)} closures, {draws} draws of each effect; {cpu / len(rows):.2f} s of one core each, the sizing of "
        "the effect included.", "", *effects, "", *nulls, "", *other_table(rows), "", *invention_table(rows), "", *pieces])
    print(text)
    print(f"\n{time.time() - started:.0f} s on {options.jobs} cores", file=sys.stderr)
    if options.page:
        page = options.page.read_text()
        before, after = page.index(BEGIN) + len(BEGIN), page.index(END)
        options.page.write_text(page[:before] + "\n" + text + "\n" + page[after:])
    sound = (named["right"] >= .95 * named["seen"] and named["wrong"] <= .05 * named["seen"] and
             alarms["alarms"] <= .03 * alarms["machines"] and of_pieces["alarms"] <= .03 * of_pieces["machines"] and
             of_pieces["named"] >= .95 * of_pieces["cut"])
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
