#!/usr/bin/env python3
"""A sample does what its expected/ folder says.

    samples_test.py SAMPLE_DIR PROGRAM OUTPUT_DIR [--accept]

Runs SAMPLE_DIR/run.sh into OUTPUT_DIR and compares each file of SAMPLE_DIR/expected with what came out: the words must be
equal, the numbers agree to RELATIVE or ABSOLUTE (last digits depend on compiler and processor); in folders of
expected/, which hold what controls load, to RELATIVE or the last digit that is written. --accept writes what came out
into expected/ instead, for the files that it has (all text files, if it is empty).
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

RELATIVE = 1e-4
ABSOLUTE = 2e-4  # um, urad, mm, deg: a fifth of a nanometre in what reports show
HASH = re.compile(r"(?<![\w.])[0-9a-f]{12,64}(?![\w.])")  # of files whose last digits may differ; no decimals
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def last_digit(number):
    decimals = number.partition(".")[2]
    return 1.5 * 10.0 ** -len(decimals) if decimals.isdigit() else 0


def same_line(wanted, found, loaded=False):
    if wanted == found:
        return True
    wanted, found = HASH.sub("hash", wanted), HASH.sub("hash", found)
    if re.sub(r"\s+", " ", NUMBER.sub("#", wanted)) != re.sub(r"\s+", " ", NUMBER.sub("#", found)):
        return False
    for w, f in zip(NUMBER.findall(wanted), NUMBER.findall(found)):
        if abs(float(w) - float(f)) > max(last_digit(w) if loaded else ABSOLUTE, RELATIVE * abs(float(w))):
            return False
    return True


def compare(wanted_file, found_file, loaded):
    wanted = wanted_file.read_text(encoding="utf-8").splitlines()
    found = found_file.read_text(encoding="utf-8").splitlines()
    for number, (w, f) in enumerate(zip(wanted, found), 1):
        if not same_line(w, f, loaded):
            yield f"{wanted_file.name}:{number}: wanted {w!r}, found {f!r}"
    if len(wanted) != len(found):
        yield f"{wanted_file.name}: wanted {len(wanted)} lines, found {len(found)}"


def relative_files(folder):
    return sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())


def main():
    sample, program, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    accept = "--accept" in sys.argv[4:]
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    done = subprocess.run([sample / "run.sh", out], env={**os.environ, "TRUNNION": str(program)},
                          stdin=subprocess.DEVNULL, check=False)
    if done.returncode != 0:
        print(f"{sample.name}/run.sh: exit status {done.returncode}")
        return 1
    expected = sample / "expected"
    if accept:
        expected.mkdir(exist_ok=True)
        names = relative_files(expected) or sorted(path.name for path in out.iterdir() if path.is_file())
        for name in names:
            shutil.copyfile(out / name, expected / name)
        return 0
    findings, files = [], relative_files(expected)
    if not files:
        findings.append(f"{expected}: is empty, nothing was compared")
    for name in files:
        if not (out / name).exists():
            findings.append(f"{name}: was not written")
        else:
            findings += compare(expected / name, out / name, len(name.parts) > 1)
    print("\n".join(findings[:20]) or f"{len(files)} files as expected")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
