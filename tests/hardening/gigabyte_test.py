#!/usr/bin/env python3
"""Files of a gigabyte that are no files of their kind: one clear line, exit status 2, in bounded memory and time.

    gigabyte_test.py PROGRAM SOURCE_DIR SCRATCH_DIR [BYTES]

TOML, JSON, CSV and NC of BYTES (10^9): nesting without end, one line, a thousand million in every field, keys twice, encodings
mixed, nothing but zeros; and TOML and JSON just short of the largest that is read. The program may take MEMORY of address space,
whatever the file's size, and SECONDS. The files are written one after another into SCRATCH_DIR and removed.
A program or position that asks an axis for a thousand million may also be refused by a limit (exit status 1).
"""
import pathlib
import resource
import shutil
import subprocess
import sys
import time

from commands import COMMANDS, errors, prepare, tree, words_of

MEMORY = 5 << 29   # 2.5 GB: the file itself, and what reading takes
SECONDS = 300
LARGEST_TOML, LARGEST_JSON = 1 << 24, 1 << 28
LONGEST_MESSAGE = 600
BY_NAME = {command.name: command for command in COMMANDS}


def lines_of(header, row, seed=b""):
    return header + b"\n" + seed, row + b"\n"


def toml_files():
    """What stands first, what is repeated, by what it is."""
    return {
        "nested lists": (b"a = ", b"["),
        "nested tables": (b"a = ", b"{ a = "),
        "one name": (b"", b"a"),
        "one dotted name": (b"", b"a."),
        "one text": (b'format = "', b"trunnion "),
        "1e9 in one list": (b"a = [", b"1e9, "),
        "a key twice": (b"", b'name = "x"\n'),
        "tables without end": (b"", b"[[axis.A]]\ndirection = [1e9, 1e9, 1e9]\n"),
        "UTF-16 after UTF-8": (b'format = "trunnion-machine"\n', "name = \u00e9\n".encode("utf-16-le")),
        "Latin-1 among UTF-8": (b"# ", b"gr\xfcn gr\xc3\xbcn "),
        "comments": (b"", b"# nothing here\n"),
    }


def json_files():
    return {
        "nested lists": (b"", b"["),
        "nested objects": (b"", b'{"a":'),
        "one text": (b'{"format": "', b"trunnion "),
        "1e9 in one list": (b'{"effects": [', b"1e9,"),
        "a key twice": (b"{", b'"format": "trunnion-model", '),
        "objects without end": (b'{"effects": [', b'{"id": 1e9, "origin": 1e9},'),
        "UTF-16 after UTF-8": (b'{"format": "trunnion-model",', '"name": "\u00e9",'.encode("utf-16-le")),
        "Latin-1 among UTF-8": (b'{"format": "', b"gr\xfcn gr\xc3\xbcn "),
        "blanks": (b"", b" \n"),
    }


def csv_files(header, row):
    fields = header.count(b",") + 1
    return {
        "one line": (b"", b"x"),
        "one line of commas": (b"", b","),
        "1e9 in every field": lines_of(header, b",".join([b"1e9"] * fields)),
        "nan in every field": lines_of(header, b",".join([b"nan"] * fields)),
        "inf in every field": lines_of(header, b",".join([b"inf"] * fields)),
        "a column twice": (header + b"," + header + b"\n", row + b"," + row + b"\n"),
        "brackets": lines_of(header, b"[" * 1000),
        "header after header": lines_of(header, header),
        "UTF-16 after UTF-8": (header + b"\n" + row + b"\n", (row.decode() + "\n").encode("utf-16-le")),
        "comments": (b"", b"# nothing here\n"),
        "blank lines": (b"", b"\n"),
    }


def nc_files():
    start = b"%\nG21 G90 G54\nG43.4 H1\nG1 F500 X0 Y0 Z50 A0 C0\n"
    return {
        "one line": (start, b"X1"),
        "nested brackets on one line": (start + b"G1 X", b"["),
        "a line of brackets after another": (start, b"G1 X" + b"[" * 200 + b"\n"),
        "one comment": (start, b"(("),
        "1e9 in every word": (start, b"G1 X1000000000 Y1000000000 Z1000000000 A1000000000 C1000000000 F1000000000\n"),
        "nan in every word": (start, b"G1 Xnan Ynan Znan Anan Cnan Fnan\n"),
        "a word twice": (start, b"G1 X1 X1\n"),
        "UTF-16 after UTF-8": (start, "G1 X1\n".encode("utf-16-le")),
        "Latin-1 among UTF-8": (start, b"G1 X\xfc1\n"),
    }


def cases(folder, size):
    """(command, input, what, beginning, repeated, bytes)."""
    for what, (first, part) in toml_files().items():
        yield "identify", "machine.toml", what, first, part, min(size, LARGEST_TOML)
        if what in ("nested lists", "1e9 in one list"):
            for command, name in (("identify", "machine.toml"), ("correct", "job.toml"), ("predict", "piece.toml")):
                yield command, name, what, first, part, size
    for what, (first, part) in json_files().items():
        yield "evaluate", "model.json", what, first, part, min(size, LARGEST_JSON)
    for command in ("evaluate", "correct"):
        yield command, "model.json", "nested lists", b"", b"[", size
    for name, command in (("o.csv", "identify"), ("at.csv", "evaluate")):
        text = [line for line in (folder / name).read_bytes().splitlines() if line and not line.startswith(b"#")]
        for what, (first, part) in csv_files(text[0], text[1]).items():
            yield command, name, what, first, part, size
    for what, (first, part) in nc_files().items():
        yield "correct", "part.ngc", what, first, part, size
    for command, name in (("identify", "machine.toml"), ("evaluate", "model.json"), ("identify", "o.csv"), ("correct", "part.ngc")):
        yield command, name, "zeros", b"", None, size


def write(path, first, part, size):
    """`first`, then `part` again and again; None: a hole."""
    with open(path, "wb") as file:
        file.write(first)
        if part is None:
            file.truncate(size)
            return
        block = part * ((1 << 22) // len(part))
        while file.tell() + len(block) <= size:
            file.write(block)
        file.write(part * ((size - file.tell()) // len(part)))


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def found_wrong(program, command, name, folder):
    """What is wrong with the answer, if anything; its seconds."""
    before = tree(folder).keys()
    started = time.monotonic()
    with subprocess.Popen([program, *words_of(command, command.output)], cwd=folder, stdin=subprocess.DEVNULL,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=limited) as process:
        try:
            stderr = process.communicate(timeout=SECONDS)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            return f"not done after {SECONDS} s", SECONDS
    took = time.monotonic() - started
    said = errors(subprocess.CompletedProcess([], process.returncode, b"", stderr))
    shown = stderr.decode(errors="replace").strip()[:300]
    allowed = (1, 2) if name in ("part.ngc", "at.csv") else (2,)
    if process.returncode not in allowed:
        return f"exit status {process.returncode}: {shown!r}", took
    if len(said) != 1 or len(said[0]) > LONGEST_MESSAGE or name not in said[0]:
        return f"one clear line that names the file is wanted, found {shown!r}", took
    if tree(folder).keys() != before:
        return "something is left", took
    return None, took


def main():
    program, source, scratch = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    size = int(float(sys.argv[4])) if len(sys.argv) > 4 else 10**9
    shutil.rmtree(scratch, ignore_errors=True)
    work = scratch / "work"
    work.mkdir(parents=True)
    failures, count, slowest = [], 0, (0.0, "")
    try:
        prepare(program, source, work)
        for command, name, what, first, part, length in cases(work, size):
            large = scratch / "large"
            aside = scratch / name
            write(large, first, part, length)
            (work / name).rename(aside)
            (work / name).symlink_to(large)
            wrong, took = found_wrong(program, BY_NAME[command], name, work)
            (work / name).unlink()
            aside.rename(work / name)
            large.unlink()
            count += 1
            case = f"{command} {name}, {length / 1e6:.0f} MB, {what}"
            slowest = max(slowest, (took, case))
            if wrong:
                failures.append(f"{case}: {wrong}")
                print(failures[-1], flush=True)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    print(f"{count} files within {MEMORY / 1e9:.1f} GB, the slowest {slowest[0]:.1f} s ({slowest[1]})")
    print("\n".join(failures) or "all refused with one line")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
