#!/usr/bin/env python3
"""A fleet comes out the same whatever the order, the runner and the interruptions.

    fleet_test.py PROGRAM SAMPLE_DIR SCRATCH MACHINES sh|parallel|slurm

Runs the sample fleet of so many machines by the runner. Half-way through the second stage everything that runs is killed
(SIGKILL) and the rest resumed by `batch --remaining`. The merged table must be that of the sample's expected/fleet.csv (as
far as there are machines), and, for the runner sh, byte for byte that of a second run in reverse order without interruption.
Exit status 77 where the runner is not installed.
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from samples_test import same_line  # noqa: E402

STAGES = (1, 2, 3)


class Fleet:
    def __init__(self, program, sample, folder, machines):
        self.program, self.folder = program, folder
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        subprocess.run([sys.executable, sample / "make_fleet.py", folder / "machines", str(machines)], check=True)
        for source in ("plan.toml", "../correct/part.ngc", "../correct/job.toml", "../predict/piece.toml"):
            shutil.copy(sample / source, folder)

    def batch(self, *words, status=0):
        done = subprocess.run([self.program, "batch", "plan.toml", "-o", "out", "--program", self.program, *words],
                              cwd=self.folder, capture_output=True, text=True)
        assert done.returncode == status, f"batch {words}: exit status {done.returncode}: {done.stderr}"
        return done

    def lines(self, stage):
        return (self.folder / f"out/jobs-{stage}.txt").read_text().splitlines()

    def done(self):
        return sum(path.stat().st_size > 0 for path in self.folder.glob("out/*/*.status"))


def by_shell(fleet, stage, reverse=False):
    lines = fleet.lines(stage)
    for line in reversed(lines) if reverse else lines:
        subprocess.run(["sh", "-c", line], cwd=fleet.folder, stdin=subprocess.DEVNULL)


def by_parallel(fleet, stage):
    with (fleet.folder / f"out/jobs-{stage}.txt").open() as lines:
        subprocess.run(["parallel", "--will-cite"], cwd=fleet.folder, stdin=lines, stderr=subprocess.DEVNULL)


def by_slurm(fleet, stage):
    count = len(fleet.lines(stage))
    if count:
        subprocess.run(["sbatch", "--quiet", "--wait", f"--array=1-{count}", "--output=/dev/null", "--wrap",
                        f"sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" out/jobs-{stage}.txt | sh"], cwd=fleet.folder,
                       stdout=subprocess.DEVNULL)


def kill_all_slurm_jobs():
    subprocess.run(["scancel", "--full", "--signal=KILL", "--user=root"], check=True)
    while subprocess.run(["squeue", "-h"], capture_output=True, text=True).stdout.strip():
        time.sleep(0.2)


def interrupted(fleet, stage, run, runner):
    """Runs a stage in processes of its own and kills them when half of it is done; what was done by then."""
    before, count = fleet.done(), len(fleet.lines(stage))
    child = os.fork()
    if child == 0:
        os.setsid()
        run(fleet, stage)
        os._exit(0)
    while fleet.done() < before + count // 2:
        assert os.waitpid(child, os.WNOHANG) == (0, 0), "the stage ended before half of it was done"
        time.sleep(0.02)
    if runner == "slurm":
        kill_all_slurm_jobs()
    else:  # GNU parallel gives each job a process group of its own: the session is what they share
        for entry in pathlib.Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    if os.getsid(int(entry.name)) == child:
                        os.kill(int(entry.name), signal.SIGKILL)
                except ProcessLookupError:
                    continue
    os.waitpid(child, 0)
    return fleet.done() - before


def compare_with_expected(sample, fleet, machines):
    wanted = (sample / "expected/fleet.csv").read_text().splitlines()[:machines + 1]
    found = (fleet.folder / "out/fleet.csv").read_text().splitlines()
    assert len(found) == len(wanted), f"{len(found) - 1} machines in fleet.csv"
    for number, (w, f) in enumerate(zip(wanted, found), 1):
        assert same_line(w.replace(",", " "), f.replace(",", " ")), f"fleet.csv:{number}: wanted {w}, found {f}"


def results(fleet):
    out = fleet.folder / "out"
    return {str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*"))
            if path.is_file() and not path.name.startswith("jobs-")}


def main():
    program, sample, scratch = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    machines, runner = int(sys.argv[4]), sys.argv[5]
    if {"parallel": "parallel", "slurm": "sbatch", "sh": "sh"}[runner] and not shutil.which(
            {"parallel": "parallel", "slurm": "sbatch", "sh": "sh"}[runner]):
        print(f"{runner} is not installed: skipped")
        return 77
    run = {"sh": by_shell, "parallel": by_parallel, "slurm": by_slurm}[runner]
    fleet = Fleet(program, sample, scratch / "fleet", machines)
    fleet.batch()
    run(fleet, 1)
    all_of_two = len(fleet.lines(2))
    done = interrupted(fleet, 2, run, runner)
    said = fleet.batch("--merge", status=1).stderr
    assert "jobs are not done" in said, said
    missing = json.loads((fleet.folder / "out/fleet.json").read_text())["missing"]
    fleet.batch("--remaining")
    left = len(fleet.lines(2))
    assert 0 < left <= all_of_two - done, f"{left} jobs left of {all_of_two}, {done} were done"
    assert len(missing) == left + len(fleet.lines(3)), f"{len(missing)} missing"
    assert not fleet.lines(1), "the models stand"
    for stage in STAGES:
        run(fleet, stage)
    fleet.batch("--merge")
    compare_with_expected(sample, fleet, machines)
    fleet.batch("--remaining")
    assert not any(fleet.lines(stage) for stage in STAGES), "nothing is left to do"
    if runner == "sh":
        other = Fleet(program, sample, scratch / "other", machines)
        other.batch()
        for stage in STAGES:
            by_shell(other, stage, reverse=True)
        other.batch("--merge")
        one, two = results(fleet), results(other)
        different = [name for name in sorted({*one, *two}) if one.get(name) != two.get(name)]
        assert not different, f"differ: {different[:10]}"
        # An input that changed makes its jobs, and those after them, due again.
        with (fleet.folder / "machines/m01/observations.csv").open("a") as file:
            file.write("# looked at again\n")
        fleet.batch("--remaining")
        due = [line for stage in STAGES for line in fleet.lines(stage)]
        assert due and all("/m01/" in line for line in due), "only the machine whose readings changed"
    shutil.rmtree(scratch)
    print(f"{machines} machines by {runner}: {done} of {all_of_two} jobs of the second stage before the kill, {left} resumed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
