#!/usr/bin/env python3
"""Hostile inputs: bounded memory and time, one clear line, exit status 2 (1 where a limit speaks), nothing written.

    hostile_test.py PROGRAM SOURCE_DIR [MEGABYTES]

Nesting, endless lines, numbers that are none or too large in every field, keys twice, mixed encodings, in every kind of file
that a command reads; names with blanks, quotes, line breaks and other scripts. MEGABYTES is the size of the large ones (4).
The address space is held at 3 GB or four times the input, whichever is more.
"""
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time

from commands import COMMANDS, errors, prepare, tree, words_of

failures = []
count = 0
slowest = (0.0, "")


def limited(memory):
    def apply():
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    return apply


def ask(program, words, folder, what, seconds, memory):
    global slowest
    started = time.monotonic()
    try:
        result = subprocess.run([program, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
                                timeout=seconds, preexec_fn=limited(memory), check=False)
    except subprocess.TimeoutExpired:
        failures.append(f"{what}: not done after {seconds} s")
        return None
    slowest = max(slowest, (time.monotonic() - started, what))
    return result


def refused(program, command, folder, name, data, what, seconds=20, may_pass=False):
    """`data` (bytes, or an iterator of them) in place of the input `name`."""
    global count
    count += 1
    path, aside = folder / name, folder / (name + ".aside")
    path.rename(aside)
    try:
        with open(path, "wb") as file:
            for part in [data] if isinstance(data, bytes) else data:
                file.write(part)
        size = path.stat().st_size
        before = {k: v for k, v in tree_names(folder).items()}
        what = f"{command.name} {name}: {what}"
        result = ask(program, words_of(command, command.output), folder, what, seconds + size / 5e6,
                     max(3 << 30, 4 * size))
        if result is None:
            return
        if may_pass and result.returncode == 0:
            target = folder / command.output
            shutil.rmtree(target) if target.is_dir() else os.remove(target)
            return
        text = result.stderr.decode(errors="replace")
        if result.returncode not in (1, 2):
            failures.append(f"{what}: exit status {result.returncode}: {text.strip()[-200:]!r}")
        elif len(errors(result)) != 1 or len(errors(result)[0]) > 600:
            failures.append(f"{what}: one clear line is wanted, found {text.strip()[:300]!r}")
        elif name not in errors(result)[0] and "memory" not in errors(result)[0] and may_pass is False:
            failures.append(f"{what}: the line does not name the file: {errors(result)[0]!r}")
        if tree_names(folder) != before:
            failures.append(f"{what}: left {sorted(tree_names(folder).keys() ^ before.keys())}")
    finally:
        os.remove(path)
        aside.rename(path)


def tree_names(folder):
    return {str(p.relative_to(folder)): p.stat().st_size for p in folder.rglob("*")}


def repeated(part, size):
    block = part * max(1, (1 << 20) // len(part))
    for _ in range(max(1, size // len(block))):
        yield block


BAD_NUMBERS = ["nan", "inf", "-inf", "1e9", "-1e9", "1e308", "1e999", "0x10", "1,5", "", "١٢", "1e-320"]


def tables_of_text(program, folder, size):
    """Everything that is nested, endless, or no text."""
    kinds = {"machine.toml": "[a", "job.toml": "[a", "piece.toml": "[a", "model.json": "[", "o.csv": ",", "at.csv": ",",
             "part.ngc": "["}
    for command in COMMANDS:
        for name in command.inputs:
            if name not in kinds or (name == "machine.toml" and command.name not in ("identify", "tables")):
                continue
            opening = kinds[name].encode()
            large = {"nesting": opening, "one endless line": b"x", "zeros": b"\0", "blank lines": b"\n",
                     "objects": b'{"a":', "inline tables": b"a={", "dotted keys": b"a.", "brackets": b"[[", "quotes": b'"',
                     "minus signs": b"-", "0xff": b"\xff", "comments": b"(" if name.endswith("ngc") else b"#"}
            for what, part in large.items():
                head = b"a = " if name.endswith("toml") and what in ("nesting", "brackets", "inline tables") else b""
                may_pass = name in ("part.ngc", "job.toml") and what in ("blank lines", "comments")
                refused(program, command, folder, name, iter([head, *repeated(part, size)]), what, may_pass=may_pass)
            good = (folder / name).read_bytes()
            if name == "part.ngc":
                continue  # a program's comments are the user's bytes
            refused(program, command, folder, name, good.decode().encode("utf-16"), "UTF-16")
            refused(program, command, folder, name, good + b"\xff\xfe\n", "no UTF-8 at the end")
            refused(program, command, folder, name, good[: len(good) // 2] + b"\0" + good[len(good) // 2:], "a zero byte within")


def numbers(program, folder):
    """Each number of each file in turn, replaced; a bad one is refused or a limit speaks, and nothing hangs."""
    by_name = {c.name: c for c in COMMANDS}
    for name, command in (("machine.toml", "identify"), ("job.toml", "correct"), ("piece.toml", "predict"), ("model.json", "evaluate")):
        text = (folder / name).read_text()
        places = [m.span() for m in re.finditer(r"(?<![\w.\"#-])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w\".])", text)]
        step = max(1, len(places) // 12)
        for start, end in places[::step]:
            for bad in BAD_NUMBERS:
                if bad in ("1,5", "") or (bad in ("١٢", "0x10") and name != "model.json"):
                    continue
                changed = text[:start] + bad + text[end:]
                refused(program, by_name[command], folder, name, changed.encode(), f"{bad} for {text[start:end]} at {start}",
                        may_pass="a number may be large")
    for name, command in (("o.csv", "identify"), ("at.csv", "evaluate")):
        lines = (folder / name).read_text().splitlines()
        header = next(i for i, line in enumerate(lines) if not line.startswith("#"))
        cells = lines[header + 1].split(",")
        for column in range(len(cells)):
            for bad in BAD_NUMBERS:
                if bad == "1,5":
                    continue
                row = cells[:column] + [bad] + cells[column + 1:]
                changed = "\n".join([*lines[: header + 1], ",".join(row), *lines[header + 2:]]) + "\n"
                refused(program, by_name[command], folder, name, changed.encode(),
                        f"{bad!r} in column {lines[header].split(',')[column]}", may_pass="a number may be large")
        for bad in BAD_NUMBERS:  # all fields at once
            changed = "\n".join([*lines[: header + 1], *[",".join([bad] * len(cells))] * 300]) + "\n"
            refused(program, by_name[command], folder, name, changed.encode(), f"{bad!r} in every field", may_pass="a number may be large")
    for bad in ("1e9", "999999999", "1000000000000000000000", "nan", "inf"):
        for axis in "XYZACFN":
            program_text = f"%\nG21 G90 G54\nG43.4 H1\nG1 F500 X0 Y0 Z50 A0 C0\nG1 {axis}{bad}\nM2\n%\n"
            refused(program, by_name["correct"], folder, "part.ngc", program_text.encode(), f"{axis}{bad}",
                    may_pass="a sequence number may be large")


def keys(program, folder):
    by_name = {c.name: c for c in COMMANDS}
    model = (folder / "model.json").read_text()
    refused(program, by_name["evaluate"], folder, "model.json", model.replace("{", '{"format": "trunnion-model",', 1).encode(), "a key twice")
    for name, command in (("machine.toml", "identify"), ("piece.toml", "predict")):
        text = (folder / name).read_text()
        key = next(line for line in text.splitlines() if line.startswith("format"))
        refused(program, by_name[command], folder, name, (key + "\n" + text).encode(), "a key twice")
    many = "".join(f"k{i} = 1\n" for i in range(200000))
    refused(program, by_name["correct"], folder, "job.toml", many.encode(), "200000 keys")
    header = ",".join(f"c{i}" for i in range(100000))
    refused(program, by_name["identify"], folder, "o.csv", (header + "\n" + header + "\n").encode(), "100000 columns")


NAMES = ["with blank", "quo'te", 'dou"ble', "back\\slash", "new\nline", "$(touch hacked)", "`touch hacked`", "-dash", "ümlaut",
         "日本", "a;b&c|d", "%n%s", "*?[x]", "#hash", "tab\there", "\u202eright-to-left"]


def names(program, folder):
    """Files of any name are read and written, and nothing in a name is executed."""
    global count
    for name in NAMES:
        for command in COMMANDS:
            if command.name in ("plan", "predict"):
                continue
            count += 1
            place = folder / name
            place.mkdir()
            words = words_of(command, os.path.join("./" + name, command.output))
            for file in command.inputs:
                renamed = os.path.join("./" + name, file.replace(".", name + ".", 1))
                if command.name == "report":
                    shutil.copytree(folder / "closed_before", place / name)
                    words = [os.path.join("./" + name, name) if word == "closed_before" else word for word in words]
                    continue
                shutil.copyfile(folder / file, folder / renamed)
                words = [renamed if word == file else word for word in words]
            result = subprocess.run([program, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False)
            if result.returncode != 0:
                failures.append(f"{command.name} in a folder {name!r}: {result.stderr.decode(errors='replace').strip()[:200]}")
            elif not (place / command.output).exists():
                failures.append(f"{command.name} in a folder {name!r}: wrote nothing")
            shutil.rmtree(place)
    if list(folder.rglob("hacked")):
        failures.append("a file name was executed")


def machine_names(program, folder):
    """A machine's name cannot leave its string in generated files, nor break a line of a program."""
    global count
    text = (folder / "machine.toml").read_text()
    evil = 'x"; system("touch hacked"); /* */ // \\" *) ) (M30\nM30'
    found = re.search(r'^name = .*$', text, re.M).group(0)
    (folder / "machine.toml").write_text(text.replace(found, "name = " + json.dumps(evil)))
    try:
        for words, output in ((["identify", "--machine", "machine.toml", "--observations", "o.csv", "-o", "evil.json"], "evil.json"),
                              (["tables", "--machine", "machine.toml", "--model", "evil.json", "--controller", "linuxcnc", "-o", "evil"], "evil"),
                              (["correct", "--machine", "machine.toml", "--model", "evil.json", "--job", "job.toml", "part.ngc", "-o", "evil.ngc"], "evil.ngc")):
            count += 1
            result = subprocess.run([program, *words], cwd=folder, capture_output=True, timeout=60, check=False)
            if result.returncode == 2 and len(errors(result)) == 1 and not (folder / output).exists():
                return  # such a name is refused: as good
            if result.returncode != 0:
                failures.append(f"{words[0]} with a name that bites: {result.stderr.decode()[-200:]!r}")
                return
        for path in [*(folder / "evil").rglob("*.comp"), folder / "evil.ngc", *(folder / "evil").rglob("*.ini"), *(folder / "evil").rglob("*.hal")]:
            lines = path.read_text().splitlines()
            if any(line.strip() == "M30" or line.lstrip().startswith("M30") for line in lines if "evil" not in line) and path.suffix != ".ngc":
                failures.append(f"{path.name}: the name broke a line")
            for line in lines:
                bare = re.sub(r'"(?:[^"\\]|\\.)*"', '""', line)
                bare = re.sub(r"//.*|/\*.*?\*/|\(.*\)$|^#.*|^\s*\*.*", "", bare)
                if "system(" in bare:
                    failures.append(f"{path.name}: the name left its string: {line!r}")
    finally:
        (folder / "machine.toml").write_text(text)
        for left in ("evil.json", "evil.ngc"):
            (folder / left).unlink(missing_ok=True)
        shutil.rmtree(folder / "evil", ignore_errors=True)


def main():
    program, source = str(pathlib.Path(sys.argv[1]).resolve()), sys.argv[2]
    size = int(float(sys.argv[3]) * 1e6) if len(sys.argv) > 3 else 1_000_000
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prepare(program, source, folder)
        tables_of_text(program, folder, size)
        keys(program, folder)
        if size < 100_000_000:
            numbers(program, folder)
            names(program, folder)
            machine_names(program, folder)
    print(f"{count} cases, the slowest {slowest[0]:.1f} s ({slowest[1]})")
    print("\n".join(failures) or "all refused, or read, in bounded time and memory")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
