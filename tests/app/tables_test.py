#!/usr/bin/env python3
"""What stands in the folders that `tables` writes: drafts that say what they are, papers that name files which are there, and
answers that are taken.

    tables_test.py PROGRAM SOURCE_DIR OUTPUT_DIR

For each controller, with a model that holds a backlash so that every question is asked:
  a draft     exit status 1; every file is named *.DRAFT.* and says so in itself, or is listed in LOADING.md as one that takes no
              comments; LOADING.md and COMMISSIONING.md name the machine, its serial number, the model and the date, steps in
              order, and how to undo them; every file named in them is there
  confirmed   the lines that COMMISSIONING.md gives, written into the machine file: exit status 0, no draft is left in the folder
  other way   every question's last answer in place of the first: taken alike
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

CONTROLLERS = ["linuxcnc", "sinumerik-840d", "isg-twincat", "heidenhain", "fanuc-30i", "aerotech"]
PAPERS = {"LOADING.md", "COMMISSIONING.md", "verification.json", "verification.txt"}
DATE = "2026-11-26"
LINE = "NOT LOAD-READY"


class Failed(Exception):
    pass


def check(good, text):
    if not good:
        raise Failed(text)


def with_backlash(model):
    effects = model["effects"]
    for axis, reversal in [("A", -17), ("C", 24)]:
        effects.append({"id": f"backlash:{axis}", "origin": "machine",
                        "parameters": {"reversal": {"value": reversal, "unit": "urad"}}})
    return model


def tables(program, machine, model, controller, out):
    command = [program, "tables", "--machine", machine, "--model", model, "--controller", controller, "--spacing", "30",
               "--date", DATE, "--quiet", "-o", out]
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120)


def folder_of(out):
    return {str(p.relative_to(out)): p.read_text() for p in sorted(out.rglob("*")) if p.is_file()}


def named_files(text):
    """What stands between backticks and looks like a file; folders and commands do not."""
    return [word for word in re.findall(r"`([^`\s]+)`", text)
            if re.fullmatch(r"[\w./-]+\.(INI|ini|comp|hal|csv|lis|COM|CMA|TXT|NC|cal|md|json)", word)]


def check_papers(files, controller, fingerprint):
    loading = files["LOADING.md"]
    for said in ["Middle-size trunnion", "serial 0001", f"model {fingerprint}", DATE]:
        for name in PAPERS & set(files) - {"verification.json", "verification.txt"}:
            check(said in files[name], f"{name} does not say {said!r}")
    numbers = [int(n) for n in re.findall(r"^(\d)\. ", loading, re.M)]
    check(numbers[:3] == [1, 2, 3], f"LOADING.md: steps {numbers}")
    check(re.search(r"^Undo: [\w`]", loading, re.M), "LOADING.md does not say how to undo it")
    for name in PAPERS & set(files):
        for word in named_files(files[name]):
            there = word in files or any(other.endswith("/" + word) for other in files)
            check(there, f"{name} names {word}, which is not there: {sorted(files)}")
    tables_of = json.loads(files["verification.json"])["files"]
    for name in tables_of:
        check(name in files, f"verification.json names {name}")
        check(pathlib.PurePath(name).name in loading, f"LOADING.md does not say where {name} goes")
    check(any(p in loading for p in ["eferenc", "home", "Home"]), "LOADING.md says nothing of referencing the axes")


def check_draft(result, files):
    check(result.returncode == 1, f"exit status {result.returncode}, 1 is wanted: {result.stderr.strip()}")
    check("not load-ready" in result.stderr, result.stderr)
    check(LINE in files["LOADING.md"], "LOADING.md does not say NOT LOAD-READY")
    silent = re.search(r"take no comments, and only their names say DRAFT: (.*)\.$", files["LOADING.md"], re.M)
    listed = re.findall(r"`([^`]+)`", silent.group(1)) if silent else []
    said = 0
    for name, text in files.items():
        if name in PAPERS:
            continue
        check(".DRAFT" in name, f"{name}: not named a draft")
        in_itself = LINE in text[:600]
        check(in_itself != (name in listed), f"{name}: says it in itself {in_itself}, listed {name in listed}")
        said += in_itself
    check(said > 0, "no file says it in itself")


def answers(commissioning, which):
    """The lines of COMMISSIONING.md that enter answers, one a question."""
    chosen = {}
    for key, answer in re.findall(r"^# (\w+) = (\".* confirmed\")$", commissioning, re.M):
        if which == "last" or key not in chosen:
            chosen[key] = answer
    return "".join(f"{key} = {answer}\n" for key, answer in chosen.items())


def check_confirmed(program, machine, model, controller, out, lines):
    confirmed = out.parent / f"{controller}-confirmed.toml"
    text = machine.read_text()
    check("[profile]\n" in text, "a [profile] is wanted in the machine of the samples")
    confirmed.write_text(text.replace("[profile]\n", "[profile]\n" + lines))
    result = tables(program, confirmed, model, controller, out)
    check(result.returncode == 0, f"answers not taken: {result.stderr.strip()}\n{lines}")
    files = folder_of(out)
    check(not [name for name in files if "DRAFT" in name], f"drafts left: {sorted(files)}")
    check("COMMISSIONING.md" not in files, "COMMISSIONING.md is left")
    check(not any(LINE in text for text in files.values()), "a file still says NOT LOAD-READY")
    verification = json.loads(files["verification.json"])
    check(verification["load_ready"] is True and verification["unconfirmed"] == [], "verification.json: not load-ready")
    return files


def run(program, source, out, controller):
    machine = source / "samples/tables/small/machine.toml"
    model = out / "model.json"
    folder = out / controller
    result = tables(program, machine, model, controller, folder)
    files = folder_of(folder)
    check("verification.json" in files, result.stderr)
    fingerprint = re.search(r"model ([0-9a-f]{16})", files["LOADING.md"]).group(1)
    check_papers(files, controller, fingerprint)
    if controller == "linuxcnc":  # nothing of it is unverified
        check(result.returncode == 0 and "COMMISSIONING.md" not in files, result.stderr)
        return
    check_draft(result, files)
    for which in ["first", "last"]:
        lines = answers(files["COMMISSIONING.md"], which)
        asked = json.loads(files["verification.json"])["unconfirmed"]
        check([line.split()[0] for line in lines.splitlines()] == asked, f"{asked} asked, answers for {lines}")
        check_papers(check_confirmed(program, machine, model, controller, folder, lines), controller, fingerprint)


def main():
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    small = json.loads((source / "samples/tables/small/model.json").read_text())
    (out / "model.json").write_text(json.dumps(with_backlash(small)))
    failures = 0
    for controller in CONTROLLERS:
        try:
            run(program, source, out, controller)
        except Failed as failed:
            print(f"{controller}: {failed}", file=sys.stderr)
            failures += 1
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
