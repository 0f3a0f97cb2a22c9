#!/usr/bin/env python3
"""Locale and time zone change no byte of what the commands write; another processor's mathematics, no digit that counts.

    environment_test.py PROGRAM SOURCE_DIR [PROGRAM_OF_ANOTHER_BUILD]

With another processor (the C library computes sin and exp by other instructions) or build, the words must be equal and numbers
agree to the digits that the samples' tests hold: 1e-4 relative, or a fifth of a nanometre.
"""
import json
import os
import pathlib
import shutil
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from comma_locale import comma_locale  # noqa: E402
from commands import COMMANDS, prepare, run, tree, words_of  # noqa: E402
from samples_test import same_line  # noqa: E402

# The page tells the day.
TAKEN = [command for command in COMMANDS if command.name != "report"]
HASHES = {"inputs_sha256", "files_sha256"}
OLD_PROCESSOR = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F"


def results(program, folder, environment):
    """Everything that the commands write and say, by name."""
    found = {}
    for command in TAKEN:
        result = run(program, words_of(command, command.output), folder, env=environment)
        if result.returncode != command.status:
            sys.exit(f"{command.name}: {result.returncode} {result.stderr.decode()}")
        found[command.name + ": what it says"] = result.stdout
        target = folder / command.output
        if command.folder:
            found.update({f"{command.name}: {name}": text for name, text in tree(target).items() if text is not None})
            shutil.rmtree(target)
        else:
            found[f"{command.name}: {command.output}"] = target.read_bytes()
            os.remove(target)
    return found


def environments(folder):
    plain = {key: value for key, value in os.environ.items() if not key.startswith(("LC_", "LANG")) and key != "TZ"}
    yield "TZ=Pacific/Kiritimati", {**plain, "TZ": "Pacific/Kiritimati"}
    yield "TZ=America/St_Johns", {**plain, "TZ": "America/St_Johns"}
    yield "TZ=nonsense", {**plain, "TZ": ":no/such/zone"}
    yield "a locale that is not there", {**plain, "LC_ALL": "xx_XX.UTF-8"}
    yield "C.UTF-8", {**plain, "LC_ALL": "C.UTF-8"}
    comma = comma_locale(folder)
    if comma is None:
        print("left out: no locale with a decimal comma can be made (localedef)")
    else:
        yield "a decimal comma", comma


def differences(wanted, found, same):
    names = wanted.keys() ^ found.keys()
    return sorted(names) + [name for name in wanted.keys() & found.keys() if not same(wanted[name], found[name])]


def numbers_of(value, path=""):
    if isinstance(value, dict):
        for key, inner in value.items():
            if key not in HASHES:
                yield from numbers_of(inner, f"{path}/{key}")
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from numbers_of(inner, f"{path}/{i}")
    else:
        yield path, value


def main():
    program, source = str(pathlib.Path(sys.argv[1]).resolve()), sys.argv[2]
    failures = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "work"
        folder.mkdir()
        prepare(program, source, folder)
        wanted = results(program, folder, {**os.environ, "LC_ALL": "C", "TZ": "UTC"})
        if len(sys.argv) > 3:
            other = results(str(pathlib.Path(sys.argv[3]).resolve()), folder, {**os.environ, "LC_ALL": "C"})
            compared = sum(len(text) for text in wanted.values())
            for what in differences(wanted, other, same_digits):
                failures.append(f"the other build: {what}")
            print(f"{len(wanted)} results of {compared / 1e6:.1f} MB against those of the other build")
        else:
            old = results(program, folder, {**os.environ, "LC_ALL": "C", "GLIBC_TUNABLES": OLD_PROCESSOR})
            failures += [f"an older processor: {what} differs" for what in differences(wanted, old, same_digits)]
            print(f"{len(wanted)} results; {len(differences(wanted, old, lambda a, b: a == b))} of them have other last digits on an older processor")
            for what, environment in environments(pathlib.Path(name)):
                for different in differences(wanted, results(program, folder, environment), lambda a, b: a == b):
                    failures.append(f"{what}: {different} differs")
    print("\n".join(failures) or "nothing differs")
    return 1 if failures else 0


def same_digits(wanted, found):
    if wanted == found:
        return True
    try:
        a, b = wanted.decode(), found.decode()
    except UnicodeDecodeError:
        return len(wanted) == len(found)  # a mesh for the eye, in single precision
    try:
        pairs = list(zip(numbers_of(json.loads(a)), numbers_of(json.loads(b))))
        return all(p == q and same_line(str(x), str(y)) for (p, x), (q, y) in pairs)
    except ValueError:
        lines = a.splitlines(), b.splitlines()
        return len(lines[0]) == len(lines[1]) and all(same_line(x, y) for x, y in zip(*lines))


if __name__ == "__main__":
    sys.exit(main())
