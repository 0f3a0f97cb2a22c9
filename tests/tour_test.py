#!/usr/bin/env python3
"""The console blocks of a page show what the program really prints.

    tour_test.py PAGE PROGRAM SCRATCH_DIR [--write]

In a fenced block marked `console`, each line `$ command` is run (by bash, one after another, in a scratch folder that
has samples/ and machines/ in it and `trunnion` on the PATH) and what stands below it must be its standard output, numbers
as in samples_test.py; a line `…` stands for any number of lines. --write puts the real output into the page.
"""
import os
import pathlib
import shutil
import subprocess
import sys

from samples_test import same_line

ELLIPSIS = "…"


def blocks(lines):
    """(command line number, first output line number, end) of every command in a console block."""
    inside, start = False, None
    for number, line in enumerate(lines):
        if line.startswith("```"):
            if start is not None:
                yield start, start + 1, number
                start = None
            inside = line.strip() == "```console"
        elif inside and line.startswith("$ "):
            if start is not None:
                yield start, start + 1, number
            start = number


def matches(wanted, found):
    """Whether `found` reads as `wanted`, in which a line `…` stands for any lines."""
    if ELLIPSIS not in wanted:
        return len(wanted) == len(found) and all(map(same_line, wanted, found))
    cut = wanted.index(ELLIPSIS)
    if len(found) < cut or not all(map(same_line, wanted[:cut], found[:cut])):
        return False
    return any(matches(wanted[cut + 1:], found[skip:]) for skip in range(cut, len(found) + 1))


def shortened(wanted, found):
    """The real output, cut where the page cuts it: as many lines before and after a single `…`."""
    if wanted.count(ELLIPSIS) != 1:
        return found
    cut = wanted.index(ELLIPSIS)
    after = len(wanted) - cut - 1
    return found[:cut] + [ELLIPSIS] + (found[-after:] if after else [])


def main():
    page, program, scratch = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    root = pathlib.Path(__file__).resolve().parent.parent
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    for folder in ["samples", "machines"]:
        (scratch / folder).symlink_to(root / folder)
    environment = {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"}
    lines = page.read_text(encoding="utf-8").splitlines()
    findings, edits = [], []
    for start, first, end in blocks(lines):
        command = lines[start][2:]
        done = subprocess.run(["bash", "-c", command], cwd=scratch, env=environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, check=False)
        found, wanted = [line.rstrip() for line in done.stdout.splitlines()], lines[first:end]
        if done.returncode not in (0, 1) or (done.returncode == 1 and done.stderr.startswith("trunnion:")):
            findings.append(f"{page.name}:{start + 1}: {command}: exit status {done.returncode}: {done.stderr.strip()}")
        elif not matches(wanted, found):
            findings.append(f"{page.name}:{start + 1}: {command}: prints otherwise:\n  " + "\n  ".join(found[:40]))
        edits.append((first, end, shortened(wanted, found)))
    if "--write" in sys.argv[4:]:
        for first, end, found in reversed(edits):
            lines[first:end] = found
        page.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return 0
    if not edits:
        findings.append(f"{page.name}: no console block found")
    print("\n".join(findings) or f"{len(edits)} commands print what {page.name} says")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
