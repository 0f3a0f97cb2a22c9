#!/usr/bin/env python3
"""One run of each command under valgrind's memcheck: no read or jump on what was never written, no access out of bounds.

    valgrind_test.py PROGRAM SOURCE_DIR

What a command writes must be what it writes without valgrind, to the digits that count. Exit status 77 where valgrind is not installed.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from commands import COMMANDS, Command, prepare, run, tree, words_of
from environment_test import differences, same_digits

MORE = [
    Command("doctor", "doctor --machine machine.toml --observations o.csv --model model.json -o {out}".split(), [], "signs", folder=True),
    Command("history", "history add --store shop.db --machine machine.toml --model model.json --date 2026-11-26".split(), [], "shop.db"),
    Command("history list", "history list --store shop.db".split(), [], ""),
    Command("completion", "completion bash".split(), [], ""),
]
ERROR = 99


def files(folder):
    return {name: text for name, text in tree(folder).items() if text is not None}


def main():
    program, source = str(pathlib.Path(sys.argv[1]).resolve()), sys.argv[2]
    if shutil.which("valgrind") is None:
        print("left out: valgrind is missing (cmake/install-dependencies.sh develop)")
        return 77
    failures = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prepare(program, source, folder)
        for command in [*COMMANDS, *MORE]:
            plain = command.folder and command.name not in ("predict",)
            if plain:
                run(program, words_of(command, "plain"), folder, check=True)
            started = time.monotonic()
            result = subprocess.run(["valgrind", "-q", f"--error-exitcode={ERROR}", "--leak-check=no", program, *words_of(command, command.output)],
                                    cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=3000, check=False)
            if result.returncode != command.status:
                failures.append(f"{command.name}: exit status {result.returncode}: {result.stderr[-2000:]}")
            if plain and differences(files(folder / "plain"), files(folder / command.output), same_digits):
                failures.append(f"{command.name}: writes something else under valgrind")
            if plain:
                shutil.rmtree(folder / "plain")
            print(f"{command.name}: {time.monotonic() - started:.0f} s", flush=True)
    print("\n".join(failures) or "no error")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
