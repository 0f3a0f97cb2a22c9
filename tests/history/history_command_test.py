#!/usr/bin/env python3
"""trunnion history as a user meets it.

    history_command_test.py PROGRAM MACHINE.toml [postgresql://…]

Without a server the stores are SQLite files. Each test gets a store of its own.
"""
import contextlib
import csv
import hashlib
import json
import os
import pathlib
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
MACHINE = pathlib.Path(sys.argv[2]).read_text()
SERVER = sys.argv[3] if len(sys.argv) > 3 else None
SYMBOLS = ["EX", "EY", "EZ", "EA", "EB", "EC"]
TILTS, TURNS = [-90, -45, 0], [0, 90, 180, 270]
KILLS = 40


def machine_text(serial):
    return MACHINE.replace('serial = "0001"', f'serial = "{serial}"')


def model(serial="0001", shift_um=0.0, name="Middle-size trunnion"):
    """A map with 0.1 um and 0.5 urad everywhere; its C axis stands `shift_um` beside its place along X."""
    values, std = {}, {}
    for k, symbol in enumerate(SYMBOLS):
        unit = "um" if k < 3 else "urad"
        amount = shift_um if symbol == "EX" else 0.0
        values[symbol + "A"] = {"unit": unit, "data": [0.0] * len(TILTS)}
        values[symbol + "C"] = {"unit": unit, "data": [[amount] * len(TURNS) for _ in TILTS]}
        noise = 0.1 if k < 3 else 0.5
        std[symbol + "A"] = {"unit": unit, "data": [noise] * len(TILTS)}
        std[symbol + "C"] = {"unit": unit, "data": [[noise] * len(TURNS) for _ in TILTS]}
    return {"format": "trunnion-model", "version": 1,
            "machine": {"name": name, "serial": serial, "structure": "w C' A' Y' b X Z t"},
            "reference_pose_deg": {"A": 0, "C": 0},
            "effects": [{"id": "rotary_error_map", "origin": "machine", "grid_deg": {"A": TILTS, "C": TURNS},
                         "values": values, "std": std}],
            "fit": {"inputs_sha256": {}}}


class HistoryTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.store = str(self.folder / "shop.db")
        if SERVER:
            schema = f"s{os.getpid()}_{self._testMethodName.lower()}"[:60]
            subprocess.run(["psql", "-q", SERVER, "-c", f"CREATE SCHEMA {schema}"], check=True, capture_output=True)
            self.store = f"{SERVER}&options=-csearch_path%3D{schema}"

    def command(self, *words, store=None):
        return [str(PROGRAM), "history", words[0], "--store", store or self.store, *map(str, words[1:])]

    def run_history(self, *words, status=0, store=None):
        done = subprocess.run(self.command(*words, store=store), cwd=self.folder, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def write(self, serial="0001", shift_um=0.0, date="2026-01-01", **changes):
        """Files of one calibration, as arguments of add."""
        name = f"{serial}_{shift_um:g}"
        (self.folder / f"{name}.toml").write_text(machine_text(serial))
        content = model(serial, shift_um)
        content.update(changes)
        (self.folder / f"{name}.json").write_text(json.dumps(content))
        return ["--machine", f"{name}.toml", "--model", f"{name}.json", "--date", date]

    def add(self, *arguments, **options):
        return self.run_history("add", *self.write(*arguments, **options))

    def ids(self):
        return [entry["id"] for entry in json.loads(self.run_history("list", "--json").stdout)]

    def test_keeps_models_byte_for_byte(self):
        self.add(shift_um=1.5)
        self.run_history("show", 1, "-o", "back.json")
        self.assertEqual((self.folder / "back.json").read_bytes(), (self.folder / "0001_1.5.json").read_bytes())

    def test_adds_the_same_calibration_once(self):
        self.add()
        self.assertIn("stood here already", self.add().stdout)
        self.assertEqual(self.ids(), [1])
        done = self.run_history("add", *self.write(date="2026-02-01"), status=2)
        self.assertIn("stands here already as calibration 1 of 2026-01-01", done.stderr)

    def test_refuses_the_model_of_another_machine(self):
        arguments = self.write()
        (self.folder / "0001_0.toml").write_text(machine_text("0002"))
        self.assertIn("serial number", self.run_history("add", *arguments, status=1).stderr)

    def test_refuses_data_that_were_changed_since(self):
        (self.folder / "data.csv").write_text("as measured\n")
        digits = subprocess.run(["sha256sum", self.folder / "data.csv"], capture_output=True, text=True).stdout.split()[0]
        arguments = self.write(fit={"inputs_sha256": {"data.csv": digits}})
        (self.folder / "data.csv").write_text("as touched up\n")
        done = self.run_history("add", *arguments, "--data", "data.csv", status=2)
        self.assertIn(f"was made from {digits}", done.stderr)
        (self.folder / "data.csv").write_text("as measured\n")
        self.run_history("add", *arguments, "--data", "data.csv")

    def test_refuses_the_closure_of_another_machine(self):
        (self.folder / "closure.json").write_text(json.dumps(
            {"format": "trunnion-closure", "version": 1, "machine": {"name": "", "serial": "9"}, "verdict": "explained"}))
        self.run_history("add", *self.write(), "--closure", "closure.json", status=1)

    def test_compares_two_calibrations(self):
        self.add(shift_um=1)
        self.add(shift_um=4, date="2026-06-01")
        found = json.loads(self.run_history("compare", 1, 2, "--json").stdout)["errors"]
        moved = {entry["error"]: entry for entry in found}["EX0C"]
        self.assertTrue(moved["differs"])
        self.assertAlmostEqual(moved["after"] - moved["before"], 3, delta=0.01)
        self.assertFalse({entry["error"]: entry for entry in found}["EZ0A"]["differs"])

    def test_does_not_compare_different_machines(self):
        self.add()
        self.add(serial="0002")
        self.assertIn("serial number", self.run_history("compare", 1, 2, status=1).stderr)
        self.assertIn("--serial", self.run_history("trend", status=2).stderr)

    def test_raises_the_alarm_beyond_a_limit(self):
        for k, shift in enumerate([1, 2, 6]):
            self.add(shift_um=shift, date=f"2026-0{k + 1}-01")
        limits = self.folder / "limits.toml"
        limits.write_text('format = "trunnion-limits"\nversion = 1\n[value]\nEX0C = 7\n[change]\nEX0C = 4\n')
        done = self.run_history("trend", "--limits", "limits.toml", "-o", "trend.csv", status=1)
        self.assertIn("alarm: EX0C has changed by 5.0", done.stderr)
        self.assertNotIn("alarm: EX0C: ", done.stderr)
        text = (self.folder / "trend.csv").read_text().splitlines()
        rows = [r for r in csv.DictReader(text) if r["error"] == "EX0C"]
        self.assertEqual([round(float(r["value"]), 3) for r in rows], [1, 2, 6])
        for r in rows:
            self.assertAlmostEqual(float(r["high"]) - float(r["low"]), 2 * 1.959964 * float(r["std"]), places=5)
        limits.write_text('format = "trunnion-limits"\nversion = 1\n[value]\nEX0C = 7\n')
        self.run_history("trend", "--limits", "limits.toml")
        limits.write_text('format = "trunnion-limits"\nversion = 1\n[value]\nEX0B = 7\n')
        self.assertIn("the nearest is EX0C", self.run_history("trend", "--limits", "limits.toml", status=2).stderr)

    def test_says_what_moved_and_when(self):
        for k, shift in enumerate([1, 1, 1, 5, 5]):
            self.add(shift_um=shift + 1e-6 * k, date=f"2026-0{k + 1}-01")
        self.run_history("drift", "-o", "drift.json")
        (change,) = json.loads((self.folder / "drift.json").read_text())["rotary_errors"]["changes"]
        self.assertEqual([change["error"], change["kind"], change["from"][:10], change["to"][:10]],
                         ["EX0C", "step", "2026-03-01", "2026-04-01"])
        self.assertAlmostEqual(change["largest"]["amount"], 4, delta=0.01)

    def test_carries_on_with_the_drift_that_was_seen(self):
        for k, shift in enumerate([1.0, 1.3, 0.9, 1.2]):
            self.add(shift_um=shift, date=f"2026-0{k + 1}-01")
        self.run_history("prior", "--date", "2026-03-01", "-o", "prior.json", status=2)
        self.run_history("prior", "--date", "2026-04-01", "-o", "now.json")
        self.run_history("prior", "--date", "2027-04-01", "-o", "later.json")
        now, later = (json.loads((self.folder / f"{n}.json").read_text())["fit"]["drift"] for n in ("now", "later"))
        self.assertEqual(now, {"um": 0, "urad": 0})
        # 0.3 um up and down from month to month, told to 0.06 um: about 0.3 * sqrt(12) um a year
        self.assertTrue(0.5 < later["um"] < 4, later)

    def test_takes_two_processes_at_once(self):
        each, running = 10, []
        for worker in range(2):
            script = []
            for k in range(each):
                words = self.command("add", *self.write(serial=f"w{worker}", shift_um=k, date="2026-01-01"))
                script.append(" ".join(f"'{w}'" for w in words) + " >/dev/null")
            running.append(subprocess.Popen(["sh", "-ec", "\n".join(script)], cwd=self.folder))
        self.assertEqual([process.wait(120) for process in running], [0, 0])
        self.assertEqual(sorted(self.ids()), list(range(1, 2 * each + 1)))

    @unittest.skipIf(SERVER, "a file's matter")
    def test_lets_processes_make_a_new_file_at_once(self):
        words = self.write()
        for k in range(15):
            store = f"new{k}.db"
            running = [subprocess.Popen(self.command("add", *words, store=store), cwd=self.folder, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.PIPE, text=True) for _ in range(12)]
            said = [process.communicate(timeout=120)[1] for process in running]
            self.assertEqual([process.returncode for process in running], [0] * 12, said)

    def test_survives_a_kill_at_any_moment(self):
        rng = random.Random(7)
        said_done = set()
        start = time.monotonic()
        self.run_history("add", *self.write(serial="k", shift_um=0))
        whole = time.monotonic() - start
        for k in range(1, KILLS + 1):
            process = subprocess.Popen(self.command("add", *self.write(serial="k", shift_um=k)), cwd=self.folder,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(rng.uniform(0, 1.2 * whole))
            process.send_signal(signal.SIGKILL)
            if process.wait() == 0:
                said_done.add(k)
        stored = json.loads(self.run_history("list", "--json").stdout)
        for entry in stored:
            self.run_history("show", entry["id"])  # its model has the hash that was stored with it
        shas = {entry["model_sha256"] for entry in stored}
        for k in said_done:
            content = (self.folder / f"k_{k}.json").read_bytes()
            self.assertIn(hashlib.sha256(content).hexdigest(), shas, "a calibration that was reported as kept")
        self.add(serial="k", shift_um=1000)  # and it goes on
        if not SERVER:
            with contextlib.closing(sqlite3.connect(self.store)) as database:
                self.assertEqual(database.execute("PRAGMA integrity_check").fetchone()[0], "ok")

    @unittest.skipIf(SERVER, "a file's matter")
    def test_names_what_is_no_history(self):
        (self.folder / "text.db").write_text("not a database at all, but a text long enough to look at\n" * 20)
        with contextlib.closing(sqlite3.connect(self.folder / "other.db")) as database:
            database.execute("CREATE TABLE customers (name TEXT)")
            database.commit()
        before = (self.folder / "other.db").read_bytes()
        for store, words in [("text.db", "is no history of trunnion"), ("other.db", "is no history of trunnion"),
                             (".", "is no file"), ("missing.db", "cannot be opened"), ("none/shop.db", "cannot be opened")]:
            done = self.run_history("list", store=store, status=2)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)
        self.run_history("add", *self.write(), store="other.db", status=2)
        self.assertEqual((self.folder / "other.db").read_bytes(), before)
        self.assertFalse((self.folder / "missing.db").exists())

    @unittest.skipIf(SERVER, "a file's matter")
    def test_notices_damage(self):
        self.add()
        with contextlib.closing(sqlite3.connect(self.store)) as database:
            database.execute("UPDATE trunnion_calibration SET model = replace(model, '0.0', '0.1')")
            database.commit()
        self.assertIn("is damaged", self.run_history("show", 1, status=2).stderr)

    @unittest.skipIf(SERVER, "a file's matter")
    def test_keeps_a_store_of_any_name(self):
        for name in ["a shop's \"db\"", ":memory:", "file:x?mode=memory", "Prüf\nstand.db", "-x.db"]:
            words = self.command("add", *self.write())
            words[words.index("--store"):words.index("--store") + 2] = [f"--store={name}"]
            self.assertEqual(subprocess.run(words, cwd=self.folder, capture_output=True, timeout=60).returncode, 0, name)
            self.assertTrue((self.folder / name).is_file(), name)

    @unittest.skipUnless(SERVER, "a server's matter")
    def test_names_a_server_that_does_not_answer(self):
        done = self.run_history("list", store="postgresql://user:secret@/nothing?host=/nowhere", status=2)
        self.assertNotIn("secret", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
