#!/usr/bin/env python3
"""Runs the program on the cases of a folder.

    cases_test.py PROGRAM SOURCE_DIR golden|rejected [CASE]

A case is a folder with a README whose first line says what it is about, a file `command` (arguments, one line; {source} and
{case} are replaced) and
  golden:    expected/ with every file that must be written, byte for byte;
  rejected:  message, what must stand on standard error (with {case} for its folder), and status, 2 unless the file says 1;
             nothing may be written, nor printed on standard output.
Commands run in an empty folder. `--update` in place of CASE writes expected/ and message anew: read the difference before it is
committed.
"""
import pathlib
import shlex
import subprocess
import sys
import tempfile


def run(program, source, case, folder):
    def filled(text):
        return text.replace("{source}", str(source)).replace("{case}", str(case))
    command = [program] + shlex.split(filled((case / "command").read_text()))
    return subprocess.run(command, cwd=folder, capture_output=True, timeout=60)


def written(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def check_golden(result, files, case, update):
    if result.returncode != 0:
        return f"exit status {result.returncode}: {result.stderr.decode(errors='replace').strip()}"
    expected_folder = case / "expected"
    if update:
        for name, content in files.items():
            (expected_folder / name).parent.mkdir(parents=True, exist_ok=True)
            (expected_folder / name).write_bytes(content)
    expected = written(expected_folder)
    if set(files) != set(expected):
        return f"wrote {sorted(files)}, expected {sorted(expected)}"
    for name, content in files.items():
        if content != expected[name]:
            lines = zip(content.splitlines(), expected[name].splitlines())
            at = next((i for i, (a, b) in enumerate(lines, 1) if a != b), "the end")
            return f"{name}: differs from what is expected at line {at}"
    return None


def check_rejected(result, files, case, update):
    message = result.stderr.decode(errors="replace").replace(str(case), "{case}")
    if update:
        (case / "message").write_text(message)
    status = int((case / "status").read_text()) if (case / "status").exists() else 2
    if result.returncode != status:
        return f"exit status {result.returncode}, expected {status}: {message.strip()}"
    if files:
        return f"wrote {sorted(files)}"
    if result.stdout:
        return f"printed {result.stdout[:80]!r}"
    expected = (case / "message").read_text()
    return None if message == expected else f"said {message!r}, expected {expected!r}"


def main():
    program, source, kind = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3]
    only = sys.argv[4] if len(sys.argv) > 4 else None
    check = check_golden if kind == "golden" else check_rejected
    cases = [c for c in sorted((source / "tests" / kind).iterdir()) if (c / "command").exists()]
    failures = 0
    for case in cases:
        if only not in (None, "--update", case.name):
            continue
        if not (case / "README").exists():
            finding = "has no README"
        else:
            with tempfile.TemporaryDirectory() as folder:
                result = run(program, source, case, folder)
                finding = check(result, written(pathlib.Path(folder)), case, only == "--update")
        if finding:
            failures += 1
            print(f"{kind}/{case.name}: {finding}")
    print(f"{len(cases)} {kind} cases, {failures} failed")
    return 1 if failures or not cases else 0


if __name__ == "__main__":
    sys.exit(main())
