"""plan --nc linuxcnc: the program goes through LinuxCNC's rs274, and what it logs is imported. rs274 meets every face at
the end of the probing move, so that each contact lies the overtravel behind the nominal face.

    probe_program_test.py TRUNNION MACHINE FOLDER        exit status 77: LinuxCNC is not installed"""
import csv
import pathlib
import re
import shutil
import subprocess
import sys

OVERTRAVEL_MM = 4
CLOSE_MM = 2e-4


def main():
    trunnion, machine, folder = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
    if shutil.which("rs274") is None:
        return 77
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([trunnion, "plan", "--machine", machine, "--nc", "linuxcnc", "-o", folder / "plan.csv", "--quiet"],
                   check=True, stdout=subprocess.DEVNULL)
    canon = subprocess.run(["rs274", "-g", folder / "plan.ngc"], capture_output=True, text=True, check=True, cwd=folder)
    lines = re.findall(r'LOG\("(.*)"\)', canon.stdout)
    assert "PROGRAM_END" in canon.stdout, canon.stdout[-300:] + canon.stderr
    (folder / "plan.log").write_text("\n".join(lines) + "\n")
    subprocess.run([trunnion, "import", "probe-log", folder / "plan.log", "--machine", machine, "-o", folder / "read.csv",
                    "--quiet"], check=True)
    plan, read = [list(csv.DictReader((folder / name).open())) for name in ("plan.csv", "read.csv")]
    assert len(plan) == len(read) > 600, (len(plan), len(read))
    for a, b in zip(plan, read):
        for name in ("point", "artifact", "repeat", "A_dir", "C_dir"):
            assert a[name] == b[name], (a, b)
        for place, direction in (("x_mm", "nx"), ("y_mm", "ny"), ("z_mm", "nz")):
            behind = float(b[place]) - float(a[place]) - OVERTRAVEL_MM * float(a[direction])
            assert abs(behind) < CLOSE_MM, (a, b, behind)
    return 0


if __name__ == "__main__":
    sys.exit(main())
