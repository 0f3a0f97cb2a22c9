#!/usr/bin/env python3
"""Every command explains itself.

    help_test.py PROGRAM

Walks the commands as `--help` names them: each has a line of description, groups, and an example that calls it by its own
name, and says in words what an option takes.
"""
import re
import subprocess
import sys


def helped(program, path):
    return subprocess.run([program, *path, "--help"], capture_output=True, text=True, check=True).stdout


def commands_below(text):
    """Names listed under headings of commands: two blanks, a word, a description."""
    names, listing = [], False
    for line in text.splitlines():
        if re.match(r"\S.*:$", line):
            listing = line in HEADINGS
        elif listing and (found := re.match(r"  ([a-z][a-z-]*)\s+\S", line)):
            names.append(found[1])
    return names


HEADINGS = {"Subcommands:", "Measure and understand:", "Correct:", "Keep and show:"}


def main():
    program, wrong, seen = sys.argv[1], [], 0
    paths = [[]]
    while paths:
        path = paths.pop()
        text = helped(program, path)
        below = commands_below(text)
        paths += [[*path, name] for name in below]
        seen += 1
        if not re.search(rf"^  .*{' '.join(['trunnion', *path])} ", text, re.M):
            wrong.append(f"{' '.join(path)}: no example")
        wrong += [f"{' '.join(path)}: \"{cryptic}\" in the help" for cryptic in ("FLOAT", "INT:", "TEXT:{") if cryptic in text]
        if not below:
            if "Talk:" not in text:
                wrong.append(f"{' '.join(path)}: no --quiet and --json")
    if seen < 15:
        wrong.append(f"only {seen} commands found")
    print("\n".join(wrong) or f"{seen} commands explain themselves")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
