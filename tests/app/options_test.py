#!/usr/bin/env python3
"""Every option of every command stands in its manual page and in the completion of each shell.

    options_test.py PROGRAM SHARE_DIR

SHARE_DIR holds what help2man made, trunnion.1 and a page for each command and each of its own commands; without any page
there only the completions are asked.
"""
import pathlib
import re
import subprocess
import sys

from help_test import commands_below, helped


def options_of(text):
    """Names of the options in a help text."""
    rows = re.findall(r"^  ((?:-\w,)?--[a-z][a-z-]*)(?=\s)", text, re.M)
    return [name for row in rows for name in row.split(",")]


def tree(program):
    """Every command as its words, with its options."""
    paths, found = [[]], {}
    while paths:
        path = paths.pop()
        text = helped(program, path)
        paths += [[*path, name] for name in commands_below(text)]
        found[" ".join(["trunnion", *path])] = options_of(text)
    return found


def completed(program, shell, command):
    """The part of a completion script that speaks of the options of `command`."""
    script = completed.scripts.setdefault(shell, subprocess.run([program, "completion", shell], capture_output=True, text=True,
                                                                check=True).stdout)
    if shell == "bash":
        return " ".join(re.findall(rf"^    '{command}'\) words='(.*)' ;;$", script, re.M)).split()
    if shell == "zsh":
        block = re.search(rf"^    '{command}'\)$(.*?) ;;$", script, re.M | re.S)
        return re.findall(r"'(--?[a-z-]+):", block[1]) if block else []
    words = command.split()[1:]
    seen = "; and ".join(f"__fish_seen_subcommand_from {word}" for word in words) or "__fish_use_subcommand"
    lines = [line for line in script.splitlines() if line.startswith(f"complete -c trunnion -n '{seen}' ")]
    return [name for line in lines for name in
            ["--" + word for word in re.findall(r" -l ([a-z-]+)", line)] + ["-" + word for word in re.findall(r" -s (\w)", line)]]


completed.scripts = {}


def main():
    program, share = sys.argv[1], pathlib.Path(sys.argv[2])
    commands, wrong, count = tree(program), [], 0
    pages = (share / "trunnion.1").exists()
    for command, options in commands.items():
        page = share / (command.replace(" ", "-") + ".1")
        manual = re.sub(r"\\f\w", "", page.read_text(encoding="utf-8")).replace("\\-", "-") if page.exists() else ""
        if not {"-h", "--help"} <= set(options) or ("-o" in options) != ("--output" in options):
            wrong.append(f"{command}: -h is --help, -o is --output: {sorted(options)}")
        for name in options:
            count += 1
            if pages and not re.search(rf"(?<![\w-]){name}(?![\w-])", manual):
                wrong.append(f"{command} {name}: not in {page.name}")
            wrong += [f"{command} {name}: not completed by {shell}" for shell in ("bash", "zsh", "fish")
                      if name not in completed(program, shell, command)]
    if count < 150:
        wrong.append(f"only {count} options found")
    print("\n".join(wrong) or f"{count} options of {len(commands)} commands" + (", manual pages too" if pages else ""))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
