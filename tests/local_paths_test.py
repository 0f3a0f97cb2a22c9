#!/usr/bin/env python3
"""No file of the project names a folder of the machine it was written on.

    local_paths_test.py SOURCE_DIR

Reads what git tracks, or every file outside build/ where there is no git. Exit status 1 and a line for each finding.
"""
import pathlib
import re
import subprocess
import sys

# Split so that this file does not find itself.
FOLDERS = ["wo" "rk", "ro" "ot", "ho" "me", "fa" "rm"]
PLACE = re.compile(r"(?<![\w.\-/~*}>)\"'])/(?:" + "|".join(FOLDERS) + r")/\w|(?<=[\"'])/(?:" + "|".join(FOLDERS) + r")/\w")


def tracked(root):
    try:
        listed = subprocess.run(["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                                capture_output=True, check=True)
        return [root / name for name in listed.stdout.decode().split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        return [path for path in root.rglob("*") if path.is_file() and "build" not in path.relative_to(root).parts[:1]]


def main():
    root = pathlib.Path(sys.argv[1])
    findings, read = [], 0
    for path in tracked(root):
        try:
            text = path.read_text(encoding="utf-8")
        except (UnicodeDecodeError, OSError):
            continue
        read += 1
        for number, line in enumerate(text.splitlines(), 1):
            if PLACE.search(line):
                findings.append(f"{path.relative_to(root)}:{number}: {line.strip()[:100]}")
    print("\n".join(findings) or f"{read} files name no folder of one machine")
    return 1 if findings or read == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
