#!/usr/bin/env python3
"""What was made for one serial number is refused for another, wherever two such files meet; a changed file is named by its hash.

    serial_test.py PROGRAM SOURCE_DIR
"""
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

failures = []
count = 0


def expect(condition, what):
    if not condition:
        failures.append(what)


class Folder:
    def __init__(self, program, source, folder):
        self.program, self.source, self.folder = program, source, folder

    def run(self, words):
        return subprocess.run([self.program, *words.split()], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=300, check=False)

    def must(self, words):
        result = self.run(words)
        if result.returncode != 0:
            sys.exit(f"{words}: {result.returncode} {result.stderr}")

    def prepare(self):
        sample = self.source / "samples"
        for name, origin in {"o.csv": "calibrate/replica.csv", "part.ngc": "correct/part.ngc", "piece.toml": "predict/piece.toml",
                             "at.csv": "calibrate/positions.csv", "job.toml": "correct/job.toml"}.items():
            (self.folder / name).write_bytes((sample / origin).read_bytes())
        text = (sample / "calibrate/machine.toml").read_text()
        (self.folder / "own").mkdir()
        (self.folder / "foreign").mkdir()
        (self.folder / "own/machine.toml").write_text(text)
        (self.folder / "foreign/machine.toml").write_text(text.replace('serial = "0001"', 'serial = "0002"'))
        for whose in ("own", "foreign"):
            m = f"--machine {whose}/machine.toml"
            self.must(f"identify {m} --observations o.csv -o {whose}/model.json")
            self.must(f"tables {m} --model {whose}/model.json --controller linuxcnc -o {whose}/tables")
            self.must(f"close {m} --observations o.csv -o {whose}/closed")
            self.must(f"predict {m} --model {whose}/model.json --piece piece.toml --corrected --draws 0 -o {whose}/piece")
            self.must(f"doctor {m} -o {whose}/signs")
            (self.folder / whose / "job.toml").write_text(f'{(self.folder / "job.toml").read_text()}')
            form = self.folder / whose / "signs/sign_test.csv"
            told = [line for line in form.read_text().splitlines() if line.startswith("#   stop")]
            rows = form.read_text().splitlines()
            first = next(i for i, line in enumerate(rows) if line.startswith("A_deg")) + 1
            for i, line in enumerate(told):
                rows[first + i] = ",".join(rows[first + i].split(",")[:2] + line.split("X Y Z")[1].replace(",", " ").split())
            form.write_text("\n".join(rows) + "\n")
        measured = ["phi_deg,h_mm,deviation_um"]
        for line in (self.folder / "own/piece/deviations.csv").read_text().splitlines()[1::12]:
            cells = line.split(",")
            measured.append(f"{cells[0]},{cells[1]},{cells[8]}")
        (self.folder / "measured.csv").write_text("\n".join(measured) + "\n")


# {} is "own" or "foreign"; the machine file is always the own one.
MEETINGS = {
    "evaluate, model": "evaluate --machine own/machine.toml --model {}/model.json --at at.csv -o out.csv",
    "correct, model": "correct --machine own/machine.toml --model {}/model.json --job job.toml part.ngc -o out.ngc",
    "tables, model": "tables --machine own/machine.toml --model {}/model.json --controller linuxcnc -o out_tables",
    "predict, model": "predict --machine own/machine.toml --model {}/model.json --piece piece.toml --draws 0 -o out_piece",
    "predict, tables": "predict --machine own/machine.toml --model own/model.json --piece piece.toml --draws 0 --tables {}/tables -o out_piece",
    "predict, program": "predict --machine own/machine.toml --model own/model.json --piece piece.toml --draws 0 "
                        "--program {}/piece/program_corrected.ngc -o out_piece",
    "identify, active tables": "identify --machine own/machine.toml --observations o.csv --active {}/tables -o out.json",
    "identify, active model": "identify --machine own/machine.toml --observations o.csv --active {}/model.json -o out.json",
    "identify, prior": "identify --machine own/machine.toml --observations o.csv --prior {}/model.json --drift-um 1 --drift-urad 1 -o out.json",
    "close, active tables": "close --machine own/machine.toml --observations o.csv --active {}/tables -o out_closed",
    "close, active model": "close --machine own/machine.toml --observations o.csv --active {}/model.json -o out_closed",
    "close, program": "close --machine own/machine.toml --observations o.csv --piece piece.toml --measured measured.csv "
                      "--program {}/piece/program_corrected.ngc -o out_closed",
    "doctor, model": "doctor --machine own/machine.toml --model {}/model.json",
    "doctor, form": "doctor --machine own/machine.toml --form {}/signs/sign_test.csv",
    "plan, model": "plan --machine own/machine.toml --model {}/model.json -o out.csv",
    "history add, model": "history add --store shop.db --machine own/machine.toml --model {}/model.json --date 2026-11-26",
    "history add, closure": "history add --store shop.db --machine own/machine.toml --model own/model.json --closure {}/closed/closure.json "
                            "--date 2026-11-26",
    "report": "report own/model.json {}/closed -o out.html",
}


def meetings(folder):
    global count
    for what, words in MEETINGS.items():
        count += 1
        before = {p for p in folder.folder.rglob("*")}
        refused = folder.run(words.format("foreign"))
        lines = [line for line in refused.stderr.splitlines() if line.startswith("trunnion: ") and "warning" not in line]
        expect(refused.returncode == 1, f"{what}: exit status {refused.returncode}: {refused.stderr.strip()[-300:]}")
        expect(len(lines) == 1 and "0001" in lines[0] and "0002" in lines[0], f"{what}: says {lines}")
        made = {p for p in folder.folder.rglob("*")} - before - {folder.folder / n for n in ("shop.db", "shop.db-wal", "shop.db-shm")}
        expect(not made, f"{what}: left {sorted(made)}")
        allowed = folder.run(words.format("own"))
        expect(allowed.returncode == 0, f"{what}: its own is refused: {allowed.stderr.strip()[-300:]}")
        expect("SHA-256" not in allowed.stderr, f"{what}: its own counts as changed: {allowed.stderr.strip()[-300:]}")


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def changed(folder):
    """The machine file and a table are touched: whoever reads them says so by both hashes, and goes on."""
    global count
    machine = folder.folder / "own/machine.toml"
    text, before = machine.read_text(), digest(machine)
    machine.write_text(text + "# changed\n")
    after = digest(machine)
    for what, words in MEETINGS.items():
        if what in ("report", "doctor, form", "predict, program", "close, program"):
            continue
        count += 1
        said = folder.run(words.format("own")).stderr
        expect(any(before in line and after in line for line in said.splitlines()), f"{what}: a changed machine file: says {said.strip()[-300:]!r}")
    machine.write_text(text)
    table = next((folder.folder / "own/tables").rglob("*.comp"))
    before = digest(table)
    table.write_text(table.read_text() + "\n")
    for what in ("predict, tables", "identify, active tables", "close, active tables"):
        count += 1
        said = folder.run(MEETINGS[what].format("own")).stderr
        expect(before in said and digest(table) in said and table.name in said, f"{what}: a changed table: says {said.strip()[-300:]!r}")


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Folder(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(name))
        folder.prepare()
        meetings(folder)
        changed(folder)
    print(f"{count} meetings")
    print("\n".join(failures) or "refused and told as it should be")
    return 1 if failures else 0


if __name__ == "__main__":
    os.umask(0o22)
    sys.exit(main())
