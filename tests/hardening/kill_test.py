#!/usr/bin/env python3
"""Commands killed at random moments leave every file as it was or as it should become, and nothing else.

    kill_test.py PROGRAM SOURCE_DIR TIMES [SEED]

Each command is killed TIMES times by SIGKILL at moments spread over its whole run, and asked again: half of the times over
an older result that differs, half into nothing. Afterwards the command runs to its end and must write what it always writes.
A store of calibrations holds after each kill what it held before, with or without the calibration that was being added.
"""
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from commands import COMMANDS, Command, prepare, run, tree, words_of

BATCH = Command("batch", "batch plan.toml -o {out} --program trunnion".split(), ["plan.toml"], "fleet", folder=True)
PLAN = """format = "trunnion-batch"
version = 1
seed = 1
[machines]
folder = "machines"
[tables]
controllers = ["linuxcnc"]
"""
OLD = b"what stood there before\n"


def result_of(folder, command):
    target = folder / command.output
    if command.folder:
        return {name: text for name, text in tree(target).items() if text is not None} if target.exists() else {}
    return {command.output: target.read_bytes()} if target.exists() else {}


def clear(folder, command):
    target = folder / command.output
    if target.is_dir():
        shutil.rmtree(target)
    elif target.exists():
        os.remove(target)


def put_old(folder, command, names):
    for name in names:
        path = folder / command.output / name if command.folder else folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(OLD)


def killed(program, command, folder, after_s):
    with subprocess.Popen([program, *words_of(command, command.output)], cwd=folder, stdin=subprocess.DEVNULL,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            process.wait(after_s)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
        process.wait()
        return process.returncode == -signal.SIGKILL


def check(program, command, folder, times, rng):
    run(program, words_of(command, command.output), folder, check=True)
    started = time.monotonic()
    run(program, words_of(command, command.output), folder, check=True)
    duration = time.monotonic() - started
    new = result_of(folder, command)
    clear(folder, command)
    inputs = tree(folder)
    caught, findings, seen = 0, [], {"old": 0, "new": 0, "mixed": 0}
    for turn in range(times):
        clear(folder, command)
        old = turn % 2 == 0
        if old:
            put_old(folder, command, new)
        # Half of the moments lie near the end, where files are moved.
        moment = duration * (rng.uniform(0, 1.1) if turn % 4 < 2 else rng.uniform(0.85, 1.15))
        caught += killed(program, command, folder, moment)
        left = result_of(folder, command)
        for name in left.keys() - new.keys():
            findings.append(f"{command.name}: remains {name}")
        for name in new:
            allowed = [new[name], OLD if old else None]
            if left.get(name) not in allowed:
                findings.append(f"{command.name}: {name} is neither the old file nor the new one")
        are_new = sum(left.get(name) == new[name] for name in new)
        seen["new" if are_new == len(new) else "old" if are_new == 0 else "mixed"] += 1
        after = tree(folder)
        for name in inputs:
            if after.get(name) != inputs[name]:
                findings.append(f"{command.name}: the input {name} changed")
        for name in after.keys() - inputs.keys():
            if name != command.output and not name.startswith(command.output + "/"):
                findings.append(f"{command.name}: remains {name}")
    clear(folder, command)
    run(program, words_of(command, command.output), folder, check=True)
    if result_of(folder, command) != new:
        findings.append(f"{command.name}: asked again after all that, it writes something else")
    clear(folder, command)
    print(f"{command.name}: {duration:.2f} s, killed {caught} of {times}: old {seen['old']}, new {seen['new']}, "
          f"a folder part old, part new {seen['mixed']}", flush=True)
    return findings


def prepare_fleet(folder):
    (folder / "plan.toml").write_text(PLAN)
    for name in range(200):
        place = folder / "machines" / f"m{name}"
        place.mkdir(parents=True)
        shutil.copyfile(folder / "machine.toml", place / "machine.toml")
        shutil.copyfile(folder / "o.csv", place / "observations.csv")


def kept(program, folder, findings, what):
    """Hashes of the models in the store."""
    result = run(program, "history list --store shop.db --json".split(), folder)
    if result.returncode != 0:
        findings.append(f"history: {what}: the store cannot be read: {result.stderr.decode().strip()}")
        return set()
    return {c["model_sha256"] for c in json.loads(result.stdout)}


def check_history(program, folder, times, rng):
    """`history add` killed, then asked again: each calibration once, every one intact."""
    text, findings, caught, seen = (folder / "model.json").read_text(), [], 0, {"without": 0, "with": 0}
    words = "history add --store shop.db --machine machine.toml --model added.json --date 2026-11-26".split()
    (folder / "added.json").write_text(text)
    started = time.monotonic()
    run(program, words, folder, check=True)
    duration, wanted = time.monotonic() - started, {hashlib.sha256(text.encode()).hexdigest()}
    for turn in range(times):
        model = text.replace('"fit": {', f'"fit": {{"draw": {turn}, ', 1)
        assert model != text
        (folder / "added.json").write_text(model)
        moment = duration * rng.uniform(0.2, 1.2)
        caught += killed(program, Command("history add", words, [], "shop.db"), folder, moment)
        digest = hashlib.sha256(model.encode()).hexdigest()
        found = kept(program, folder, findings, f"after kill {turn}")
        if found - {digest} != wanted:
            findings.append(f"history: after kill {turn}: {len(found)} calibrations, {len(wanted)} stood before")
        seen["with" if digest in found else "without"] += 1
        wanted.add(digest)
        run(program, words, folder, check=True)
        if kept(program, folder, findings, f"asked again after kill {turn}") != wanted:
            findings.append(f"history: asked again after kill {turn}: not each calibration once")
    for calibration in json.loads(run(program, "history list --store shop.db --json".split(), folder, check=True).stdout):
        shown = run(program, f"history show {calibration['id']} --store shop.db -o -".split(), folder, check=True).stdout
        if hashlib.sha256(shown).hexdigest() != calibration["model_sha256"]:
            findings.append(f"history: calibration {calibration['id']} is not intact")
    for path in folder.glob("shop.db*"):
        if path.name not in ("shop.db", "shop.db-wal", "shop.db-shm"):
            findings.append(f"history: remains {path.name}")
    print(f"history add: {duration:.2f} s, killed {caught} of {times}: without {seen['without']}, with {seen['with']}", flush=True)
    return findings


def main():
    program, source, times = str(pathlib.Path(sys.argv[1]).resolve()), sys.argv[2], int(sys.argv[3])
    rng = random.Random(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    findings = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prepare(program, source, folder)
        for command in COMMANDS:
            findings += check(program, command, folder, times, rng)
        findings += check_history(program, folder, times, rng)
        prepare_fleet(folder)
        findings += check(program, BATCH, folder, times, rng)
    print("\n".join(dict.fromkeys(findings)) or "every file was the old one or the new one")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
