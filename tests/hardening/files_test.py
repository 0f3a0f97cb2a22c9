#!/usr/bin/env python3
"""What the file system may do to a command: one clear line, exit status 2, no remains, no input touched.

    files_test.py PROGRAM SOURCE_DIR

For every command that writes: folder missing (a file's), folder read only, disk full, output equal to an input or a link to
one, input missing, unreadable, a folder, a pipe (which is read). What needs another user or a file system of its own is left
out where this user may not make them; that is said.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading

from commands import COMMANDS, errors, prepare, run, tree, words_of

NOBODY = 65534
failures = []
counts = {}


def expect(condition, what, result=None):
    if not condition:
        said = "" if result is None else f": {result.returncode} {result.stderr.decode(errors='replace').strip()[-300:]!r}"
        failures.append(what + said)


def refused(what, result, before, folder):
    """Exit status 2, one line, and the folder as it was."""
    kind = what.split(": ")[1]
    counts[kind] = counts.get(kind, 0) + 1
    expect(result.returncode == 2, what + ": exit status", result)
    expect(len(errors(result)) == 1, what + ": one line wanted", result)
    after = tree(folder)
    expect(after == before, what + f": left or changed {sorted(k for k in before.keys() | after.keys() if before.get(k, 0) != after.get(k, 0))}")


def bad_places(program, command, folder):
    before = tree(folder)
    if not command.folder:
        refused(f"{command.name}: missing folder", run(program, words_of(command, "nowhere/out"), folder), before, folder)
        refused(f"{command.name}: output is a folder", run(program, words_of(command, "closed_before"), folder), before, folder)
    refused(f"{command.name}: output below a file", run(program, words_of(command, "machine.toml/out"), folder), before, folder)
    for name in command.inputs:
        if command.folder or "/" in name:
            continue
        refused(f"{command.name}: output is input", run(program, words_of(command, name), folder), before, folder)
        refused(f"{command.name}: output is input", run(program, words_of(command, f"./x/../{name}" if (folder / "x").is_dir() else f".//{name}"), folder), before, folder)
        os.symlink(name, folder / "link")
        with_link = tree(folder)
        refused(f"{command.name}: output links to input", run(program, words_of(command, "link"), folder), with_link, folder)
        os.remove(folder / "link")
        os.link(folder / name, folder / "hard")
        with_link = tree(folder)
        refused(f"{command.name}: output links to input", run(program, words_of(command, "hard"), folder), with_link, folder)
        os.remove(folder / "hard")
    if command.folder:  # a folder in which an input would be overwritten: by its file, or by a link to it
        existing = next(iter(tree_of_output(program, command, folder)))
        (folder / "trap").mkdir()
        (folder / "trap" / existing).parent.mkdir(exist_ok=True)
        os.symlink(os.path.relpath(folder / command.inputs[0], (folder / "trap" / existing).parent), folder / "trap" / existing)
        with_trap = tree(folder)
        refused(f"{command.name}: output links to input", run(program, words_of(command, "trap"), folder), with_trap, folder)
        shutil.rmtree(folder / "trap")


def tree_of_output(program, command, folder):
    run(program, words_of(command, "probe_out"), folder, check=True)
    files = {name: text for name, text in tree(folder / "probe_out").items() if text is not None}
    shutil.rmtree(folder / "probe_out")
    return files


def bad_inputs(program, command, folder):
    for name in command.inputs:
        path, aside = folder / name, folder / (name.replace("/", "_") + ".aside")
        if command.name == "report":
            continue  # takes whatever its folders hold
        path.rename(aside)
        before = tree(folder)
        refused(f"{command.name}: input missing", run(program, words_of(command, command.output), folder), before, folder)
        path.mkdir()
        before = tree(folder)
        refused(f"{command.name}: input is a folder", run(program, words_of(command, command.output), folder), before, folder)
        path.rmdir()
        path.write_bytes(b"")
        before = tree(folder)
        refused(f"{command.name}: input empty" if name != "part.ngc" else f"{command.name}: program empty",
                run(program, words_of(command, command.output), folder), before, folder) if name not in ("part.ngc", "job.toml") else None
        os.remove(path)
        aside.rename(path)


def pipes(program, command, folder):
    """Every input as a pipe gives the same bytes as the file."""
    if command.name == "report":
        return
    run(program, words_of(command, command.output), folder, check=True)
    wanted = tree(folder / command.output) if command.folder else (folder / command.output).read_bytes()
    for name in command.inputs:
        read, write = os.pipe()
        text = (folder / name).read_bytes()

        def feed(fd=write, data=text):
            try:
                with os.fdopen(fd, "wb") as pipe:
                    pipe.write(data)
            except BrokenPipeError:
                pass
        thread = threading.Thread(target=feed)
        thread.start()
        words = [f"/dev/fd/{read}" if word == name else word for word in words_of(command, "from_pipe")]
        result = run(program, words, folder, pass_fds=[read])
        os.close(read)
        thread.join()
        counts["pipe as input"] = counts.get("pipe as input", 0) + 1
        if result.returncode == 0:
            # The provenance tells the name and hash of a file, which a pipe has not: compare what is no JSON, nor names a file
            # in every row.
            if command.folder:
                got = tree(folder / "from_pipe")
                expect(got.keys() == wanted.keys(), f"{command.name}: {name} as a pipe: other files")
                for file in wanted:
                    if not file.endswith((".json", "residuals.csv")):
                        expect(got.get(file) == wanted[file], f"{command.name}: {name} as a pipe: {file} differs")
            elif not command.output.endswith(".json"):
                expect((folder / "from_pipe").read_bytes() == wanted, f"{command.name}: {name} as a pipe: differs")
        else:
            expect(result.returncode == 2 and len(errors(result)) == 1, f"{command.name}: {name} as a pipe", result)
        remove(folder / "from_pipe")
    remove(folder / command.output)


def remove(path):
    if path.is_dir():
        shutil.rmtree(path)
    elif path.exists():
        os.remove(path)


def as_nobody(program, command, folder):
    """Read-only folders and unreadable inputs mean nothing to root."""
    os.chmod(folder, 0o555)
    before = tree(folder)
    refused(f"{command.name}: read-only folder", run(program, words_of(command, command.output), folder, user=NOBODY), before, folder)
    os.chmod(folder, 0o777)
    for name in command.inputs:
        if command.name == "report":
            continue
        os.chmod(folder / name, 0)
        before = tree(folder)
        refused(f"{command.name}: unreadable input", run(program, words_of(command, command.output), folder, user=NOBODY), before, folder)
        os.chmod(folder / name, 0o644)


def full_disk(program, command, folder, disk):
    """Room for nothing, and then for a part of what is written; what stood there before stays."""
    target = disk / command.output
    for room in (0, 1 << 12):
        for old in (False, True):
            remove(target)
            if old:
                run(program, words_of(command, target), folder, check=True)
            filler = disk / "filler"
            free = os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize
            filler.write_bytes(b"x" * max(free - room, 0))
            before = tree(disk)
            result = run(program, words_of(command, target), folder)
            counts["disk full"] = counts.get("disk full", 0) + 1
            if result.returncode == 0:  # it fitted
                expect(room > 0, f"{command.name}: disk full: wrote into no room")
            else:
                refused(f"{command.name}: disk full", result, before, disk)
            os.remove(filler)
    remove(target)


def main():
    program, source = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    left_out = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "work"
        folder.mkdir()
        prepare(program, source, folder)
        for command in COMMANDS:
            bad_places(program, command, folder)
            bad_inputs(program, command, folder)
            pipes(program, command, folder)
        if os.getuid() == 0:
            os.chmod(name, 0o755)
            executable = pathlib.Path(name) / "bin"  # a build folder may be closed to others
            executable.mkdir()
            for file in [pathlib.Path(program), *pathlib.Path(program).parent.glob("trunnion_*.so")]:
                shutil.copy2(file, executable)
            for command in COMMANDS:
                as_nobody(str(executable / "trunnion"), command, folder)
        else:
            left_out.append("read-only folder and unreadable input (not root)")
        disk = pathlib.Path(name) / "disk"
        disk.mkdir()
        mounted = os.getuid() == 0 and subprocess.run(["mount", "-t", "tmpfs", "-o", "size=24m", "tmpfs", disk],
                                                      stderr=subprocess.DEVNULL, check=False).returncode == 0
        if mounted:
            try:
                for command in COMMANDS:
                    full_disk(program, command, folder, disk)
            finally:
                subprocess.run(["umount", disk], check=True)
        else:
            left_out.append("full disk (no tmpfs can be mounted)")
    print(", ".join(f"{kind} {count}" for kind, count in sorted(counts.items())))
    for what in left_out:
        print("left out: " + what)
    print("\n".join(failures) or "all refused with one line, nothing left")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
