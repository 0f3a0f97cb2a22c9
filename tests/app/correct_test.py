#!/usr/bin/env python3
"""The command correct beside what golden and rejected cases can hold.

    correct_test.py PROGRAM SOURCE_DIR

- A job that says compensated_by = "tables": only what the tables leave is corrected.
- A dialect is told by the program or asked for, and the report says what was done. --tcp is obeyed.
- After a refusal nothing stands in the folder; with --keep-going the rest is corrected, played back, and the exit status is 1.
- The report tells how much of every limit is used. --decimals is obeyed. 64 MiB are enough for a long program.
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
MACHINE = SOURCE / "machines/seed-trunnion.toml"
MODEL = SOURCE / "tests/golden/shared/model.json"


def run(folder, *arguments):
    return subprocess.run([str(a) for a in (PROGRAM,) + arguments], cwd=folder, capture_output=True, text=True,
                          check=False, timeout=300)


def correct(folder, program, job, *more):
    result = run(folder, "correct", "--machine", MACHINE, "--model", MODEL, "--job", job, program, "-o", "out.nc",
                 "--report", "report.json", *more)
    report = folder / "report.json"
    return result, json.loads(report.read_text()) if report.exists() else None


def check(said, found):
    if not said:
        sys.exit(f"wrong: {found}")


def compensated_by_tables(folder):
    program = SOURCE / "samples/programs/impeller.ngc"
    tables = run(folder, "tables", "--machine", MACHINE, "--model", MODEL, "--controller", "linuxcnc", "-o", "tables")
    check((folder / "tables/verification.json").exists(), tables.stderr)
    (folder / "plain.toml").write_text("[work_offsets_mm]\nG54 = [0, 0, 0]\n")
    (folder / "played.toml").write_text('compensated_by = "tables"\ntables = "tables"\n[work_offsets_mm]\nG54 = [0, 0, 0]\n')
    _, plain = correct(folder, program, "plain.toml")
    result, played = correct(folder, program, "played.toml")
    check(played is not None, result.stderr)
    before, left = plain["playback"]["before"], played["playback"]["before"]
    check(left["position_max_um"] < 0.2 * before["position_max_um"], (before, left))
    check(played["playback"]["after"]["position_max_um"] < 0.4, played["playback"]["after"])
    check(played["compensated_by"] == "tables" and plain["compensated_by"] == "nothing", "compensated_by")
    (folder / "half.toml").write_text('compensated_by = "tables"\n')
    refused = run(folder, "correct", "--machine", MACHINE, "--model", MODEL, "--job", "half.toml", program, "-o", "x.nc")
    check(refused.returncode == 2 and "tables is missing" in refused.stderr.replace(": ", " "), refused.stderr)


def dialects(folder):
    (folder / "job.toml").write_text("[work_offsets_mm]\nG54 = [0, 0, 0]\n")
    for end, dialect in (("h", "heidenhain"), ("mpf", "sinumerik"), ("nc", "fanuc"), ("ngc", "linuxcnc")):
        result, report = correct(folder, SOURCE / f"samples/programs/turbine_blade.{end}", "job.toml")
        check(result.returncode == 0 and report["dialect"] == dialect, result.stderr)
        check(report["playback"]["after"]["position_max_um"] < 0.4, report["playback"]["after"])
        check(report["playback"]["before"]["position_max_um"] > 1, report["playback"]["before"])


def refusals(folder):
    (folder / "job.toml").write_text("[work_offsets_mm]\nG54 = [0, 0, 0]\n")
    (folder / "bad.nc").write_text("%\nO1\nG21 G90\nG43.4 H1\nG0 X10. Y0. Z50. A-30. C10.\nG1 X12. F500.\nG81 Z-5. R2.\n"
                                   "G0 X10. Y0. Z50. A-30. C20.\nG1 X14. F500.\nM30\n%\n")
    result, _ = correct(folder, "bad.nc", "job.toml")
    check(result.returncode == 1 and "bad.nc:7: G81" in result.stderr, result.stderr)
    check(sorted(p.name for p in folder.iterdir()) == ["bad.nc", "job.toml"], "files were written")
    result, report = correct(folder, "bad.nc", "job.toml", "--keep-going")
    check(result.returncode == 1 and "bad.nc:7: copied uncorrected" in result.stderr, result.stderr)
    check([r["line"] for r in report["refused"]] == [7], report["refused"])
    text = (folder / "out.nc").read_text()
    check("\nG81 Z-5. R2.\n" in text and "X14. " not in text, text)
    played = report["playback"]
    check(played["refused_blocks"] == 1 and played["copied_from_line"] == 0, played)
    check(played["after"]["position_max_um"] < 0.4 < played["before"]["position_max_um"], played)
    check("Played without 1 refused blocks" in result.stdout, result.stdout)


def limits_and_assumptions(folder):
    """How much of each limit is used, and what nobody has confirmed of the control."""
    (folder / "job.toml").write_text("[work_offsets_mm]\nG54 = [0, 0, 0]\n")
    (folder / "part.nc").write_text("%\nO1\nG5 P10000\nG21 G90\nG43.4 H1\nG0 X10. Y0. Z50. A-30. C10.\nG1 X12. F500.\nM30\n%\n")
    result, report = correct(folder, "part.nc", "job.toml", "--verbose")
    check(result.returncode == 0 and result.stderr.count("not confirmed for this control: G5 P10000") == 1, result.stderr)
    check(len(report["assumptions"]) == 1, report["assumptions"])
    limits = {one["limit"]: one for one in report["playback"]["limits"]}
    check(limits["probed A"]["used"] == [-30, -30], limits)
    check(0 < limits["limits.correction_um"]["used"] < limits["limits.correction_um"]["allowed"], limits)
    check("limits.correction_um" in result.stdout, result.stdout)


def decimals_and_memory(folder):
    """The digits asked for; and a long program takes no more memory than a short one."""
    (folder / "job.toml").write_text("[work_offsets_mm]\nG54 = [0, 0, 0]\n")
    head = "%\nG21 G90\nG0 X0 Y10 Z50 A-30 C10\nF500\n"
    (folder / "short.ngc").write_text(head + "G1 X1.5\nX1.75\nM2\n%\n")
    for digits in (3, 5):
        result, _ = correct(folder, "short.ngc", "job.toml", "--decimals", digits)
        check(result.returncode == 0, result.stderr)
        words = re.findall(r"^G1 X(\S+)", (folder / "out.nc").read_text(), re.M)
        check(len(words) == 1 and len(words[0].partition(".")[2]) == digits, (digits, words))
    with open(folder / "long.ngc", "w", encoding="utf-8") as file:
        file.write(head)
        for k in range(40):
            file.write("".join(f"G1 X{0.01 * (i % 3000):.3f} Y{10 + k} Z50. A-30.5 C{10 + 0.001 * i:.3f}\n" for i in range(10000)))
        file.write("M2\n%\n")
    words = ["correct", "--machine", MACHINE, "--model", MODEL, "--job", "job.toml", "long.ngc", "-o", "long_out.ngc", "--quiet"]
    child = subprocess.Popen([str(a) for a in [PROGRAM, *words]], cwd=folder, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    watched = b"__asan_init" in pathlib.Path(PROGRAM).read_bytes()  # the sanitizer's own memory is many times that
    check(status == 0 and (watched or used.ru_maxrss < 64 * 1024), (status, used.ru_maxrss))


def asked_for(folder):
    """Where nothing tells the dialect it is asked for; --tcp on and off count whatever the machine's file says."""
    (folder / "job.toml").write_text("[work_offsets_mm]\nG54 = [0, 0, 0]\n")
    (folder / "plain.nc").write_text("G21 G90 G54\nG0 X60. Y0. Z50. A-60. C40.\nG1 X62. F500.\nM30\n")
    told = MACHINE.read_text()
    found = {}
    for tcp in ("on", "off"):
        (folder / "machine.toml").write_text(told.replace('controller = "linuxcnc"', 'controller = "aerotech"').replace(
            'tcp = "on"', f'tcp = "{tcp}"'))
        words = ["correct", "--machine", "machine.toml", "--model", MODEL, "--job", "job.toml", "plain.nc", "-o", "out.nc"]
        asked = run(folder, *words)
        check(asked.returncode == 2 and asked.stderr.startswith("trunnion: plain.nc: its dialect is not told by the program") and
              "--dialect is wanted" in asked.stderr and not (folder / "out.nc").exists(), asked.stderr)
        for forced in ("auto", "on", "off"):
            result = run(folder, *words, "--dialect", "linuxcnc", "--tcp", forced)
            check(result.returncode == 0, result.stderr)
            found[tcp, forced] = re.sub(r"\(.*corrected by.*\)", "", (folder / "out.nc").read_text())
            (folder / "out.nc").unlink()
    check(found["on", "auto"] == found["on", "on"] == found["off", "on"], found)
    check(found["off", "auto"] == found["off", "off"] == found["on", "off"], found)
    check(found["on", "on"] != found["off", "off"], found)


def main():
    cases = (asked_for, dialects, refusals, limits_and_assumptions, decimals_and_memory, compensated_by_tables)
    for case in cases:
        with tempfile.TemporaryDirectory() as name:
            case(pathlib.Path(name))
    print(f"correct: {len(cases)} cases passed")


main()
