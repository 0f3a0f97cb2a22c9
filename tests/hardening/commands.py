"""The commands that write, on small inputs, for the tests of this folder."""
import dataclasses
import os
import pathlib
import shutil
import subprocess


@dataclasses.dataclass
class Command:
    name: str
    words: list       # the command line; names of files below the work folder
    inputs: list      # files that it reads
    output: str       # what it writes: a file, or a folder
    folder: bool = False
    status: int = 0   # what it ends with where all is well


COMMANDS = [
    Command("identify", "identify --machine machine.toml --observations o.csv -o {out}".split(),
            ["machine.toml", "o.csv"], "out.json"),
    Command("evaluate", "evaluate --machine machine.toml --model model.json --at at.csv -o {out}".split(),
            ["machine.toml", "model.json", "at.csv"], "out.csv"),
    Command("correct", "correct --machine machine.toml --model model.json --job job.toml part.ngc -o {out}".split(),
            ["machine.toml", "model.json", "job.toml", "part.ngc"], "out.ngc"),
    Command("tables", "tables --machine machine.toml --model model.json --controller linuxcnc -o {out}".split(),
            ["machine.toml", "model.json"], "tables", folder=True),
    Command("predict", "predict --machine machine.toml --model model.json --piece piece.toml --draws 20 -o {out}".split(),
            ["machine.toml", "model.json", "piece.toml"], "piece", folder=True),
    Command("close", "close --machine machine.toml --observations o.csv -o {out}".split(),
            ["machine.toml", "o.csv"], "closed", folder=True),
    Command("plan", "plan --machine machine.toml -o {out}".split(), ["machine.toml"], "plan.csv"),
    Command("report", "report closed_before -o {out}".split(), ["closed_before/closure.json"], "report.html"),
]


def prepare(program, source, folder):
    """Fills `folder` with the inputs of all commands."""
    samples = pathlib.Path(source) / "samples"
    for to, origin in {"machine.toml": "calibrate/machine.toml", "o.csv": "calibrate/replica.csv",
                       "at.csv": "calibrate/positions.csv", "job.toml": "correct/job.toml", "part.ngc": "correct/part.ngc",
                       "piece.toml": "predict/piece.toml"}.items():
        shutil.copyfile(samples / origin, folder / to)
    run(program, "identify --machine machine.toml --observations o.csv -o model.json".split(), folder, check=True)
    run(program, "close --machine machine.toml --observations o.csv -o closed_before".split(), folder, check=True)


def words_of(command, out):
    return [word.replace("{out}", str(out)) for word in command.words]


def run(program, words, folder, check=False, user=None, **more):
    result = subprocess.run([program, *words], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, timeout=300, user=user, group=user,
                            extra_groups=[] if user is not None else None, **more)
    if check and result.returncode != 0:
        raise RuntimeError(f"{words}: {result.returncode}: {result.stderr.decode(errors='replace')}")
    return result


def tree(folder):
    """Everything below a folder: bytes by name, None for what is no regular file."""
    found = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        if path.is_symlink():
            found[str(path.relative_to(folder))] = os.readlink(path)
        elif path.is_file():
            found[str(path.relative_to(folder))] = path.read_bytes()
        else:
            found[str(path.relative_to(folder))] = None
    return found


def errors(result):
    """Lines of standard error that are no warnings and no talk."""
    return [line for line in result.stderr.decode(errors="replace").splitlines() if line.startswith("trunnion: ")]
