#!/usr/bin/env python3
"""Real shells complete trunnion's words.

    completion_test.py PROGRAM SHELL

Writes the script that PROGRAM makes for SHELL (bash, zsh, fish), has the shell read it, and asks it for completions. Exit
status 77 where the shell is not installed.
"""
import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time

# What is typed, and what must be among the completions; the last word is the one to be completed.
CASES = [
    ("trunnion ident", {"identify"}),
    ("trunnion history dr", {"drift"}),
    ("trunnion identify --meth", {"--method"}),
    ("trunnion identify --method tw", {"two-step"}),
    ("trunnion history compare --st", {"--store"}),
    ("trunnion correct --orientation of", {"off"}),
    ("trunnion completion --q", {"--quiet"}),
]


def bash(script, line, _):
    words = line.split(" ")
    done = subprocess.run(
        ["bash", "--norc", "-c", "compopt() { :; }; source \"$1\"; shift; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); "
         "_trunnion; printf '%s\\n' \"${COMPREPLY[@]}\"", "-", script, *words], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def fish(script, line, _):
    done = subprocess.run(["fish", "--no-config", "-c", f"source {script}; complete -C '{line}'"],
                          capture_output=True, text=True, check=True, env={**os.environ, "HOME": str(script.parent)})
    return {row.split("\t")[0] for row in done.stdout.splitlines()}


def zsh(script, line, wanted):
    """zsh completes only at its own line editor: typed at a terminal, and what it makes of the line read back."""
    pid, terminal = pty.fork()
    if pid == 0:
        os.environ.update(TERM="dumb", HOME=str(script.parent), PS1="READY> ")
        os.execvp("zsh", ["zsh", "-f", "-i"])

    def read_until(pattern, seconds=20):
        seen, end = "", time.time() + seconds
        while time.time() < end:
            if select.select([terminal], [], [], 0.2)[0]:
                seen += os.read(terminal, 65536).decode(errors="replace")
            elif re.search(pattern, seen):
                break
        return seen
    try:
        os.write(terminal, f"PS1='READY> '; autoload -Uz compinit; compinit -D -u; source {script}; echo LOAD""ED\n".encode())
        read_until(r"LOADED\r?\n")
        os.write(terminal, (line + "\t").encode())
        seen = read_until("|".join(rf"{re.escape(word)}(?![\w-])" for word in wanted))
    finally:
        os.close(terminal)
        os.waitpid(pid, 0)
    return set(re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|[\r\x07\x08]", " ", seen).split())


def main():
    program, shell = sys.argv[1:3]
    if shutil.which(shell) is None:
        print(f"{shell} is not installed")
        return 77
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        script = pathlib.Path(folder) / "trunnion"
        script.write_text(subprocess.run([program, "completion", shell], capture_output=True, text=True, check=True).stdout)
        for line, wanted in CASES:
            found = {"bash": bash, "fish": fish, "zsh": zsh}[shell](script, line, wanted)
            if not wanted <= found:
                print(f"{shell}: {line}<TAB>: wanted {sorted(wanted)}, found {sorted(found)[:20]}")
                wrong = 1
    print(f"{shell}: {len(CASES)} lines completed" if not wrong else f"{shell}: failed")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
