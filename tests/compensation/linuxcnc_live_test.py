"""The real control with the component loaded: every sampled joint is where the model wants it.

linuxcnc_live_test.py TRUNNION SAMPLES_CALIBRATE OUT. Needs linuxcnc-uspace, -dev, and root to install the module; without them
it ends with 77 (skipped). A five-axis program runs in the simulated controller; axis commands and joints are sampled every
servo cycle. LinuxCNC's joints come two cycles after the axes, smoothed (before + 4 now + after) / 6.
"""

import csv, math, os, pathlib, shutil, sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "support"))
import simulated_control as control

LEFT_MM = 0.05e-3
DELAY = 2


def main(trunnion, calibrate, out):
    if why := control.missing("halcompile", "halsampler"):
        print(why)
        return 77
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    machine = f"{calibrate}/machine.toml"
    for command in (f"{trunnion} identify --machine {machine} --observations {calibrate}/replica.csv -o {out}/model.json",
                    f"{trunnion} tables --machine {machine} --model {out}/model.json --controller linuxcnc -o {out}/set",
                    f"cd {out}/set/kinematics && halcompile --install trunnion_kins.comp"):
        done = control.sh(command)
        if done.returncode != 0:
            sys.exit(command + ": " + done.stderr + done.stdout)
    control.configure(out)
    control.write(f"{out}/run.py", [
        "import linuxcnc, time, subprocess",
        "linuxcnc.nmlfile = '/usr/share/linuxcnc/linuxcnc.nml'",
        "c = linuxcnc.command()",
        "c.state(linuxcnc.STATE_ESTOP_RESET); c.wait_complete(20); c.state(linuxcnc.STATE_ON); c.wait_complete(20)",
        "c.home(-1); time.sleep(1); c.mode(linuxcnc.MODE_MDI); c.wait_complete(20)",
        "c.mdi('G21 G90 G61.1 G94'); c.wait_complete(20)",
        "s = subprocess.Popen(['halsampler', '-n', '9000', 'samples.txt'])",
        "for line in ['G1 X40 Y30 Z20 A-10 C20 F3000', 'G1 X-60 Y80 Z50 A-37.5 C123.4', 'G1 X90 Y-50 Z-30 A-80 C-10']:",
        "    c.mdi(line); c.wait_complete(60)",
        "s.wait(60)"])
    control.run_controller(out)

    with open(f"{out}/samples.txt") as file:
        rows = [[float(x) for x in line.split()] for line in file if len(line.split()) == 10]
    # The rotary joints as sampled; X Y Z from the model at those angles, then LinuxCNC's smoothing.
    cycles = range(2, len(rows) - DELAY - 2)
    points = {}
    for n in range(1, len(rows) - DELAY - 1):
        w, axis = rows[n][0:3], rows[n][3:5]
        before, after = rows[n - 1][3:5], rows[n + 1][3:5]
        smooth = [(b + 4 * now + f) / 6 for b, now, f in zip(before, axis, after)]
        turned = [x + joint - s for x, joint, s in zip(axis, rows[n + DELAY][8:10], smooth)]
        points[n] = (turned, control.on_table(w, *turned))
    with open(f"{out}/at.csv", "w") as file:
        file.write("A_deg,C_deg,x_mm,y_mm,z_mm\n")
        for (a, c), p in points.values():
            file.write(",".join(repr(v) for v in (min(a, 0.0), c, *p)) + "\n")
    done = control.sh(f"{trunnion} evaluate --machine {machine} --model {out}/model.json --at {out}/at.csv -o {out}/d.csv")
    if done.returncode != 0:
        sys.exit(done.stderr)
    with open(f"{out}/d.csv") as file:
        moved = {n: [p + 1e-3 * float(d[k]) for p, k in zip(points[n][1], ("dx_um", "dy_um", "dz_um"))]
                 for n, d in zip(points, csv.DictReader(file))}
    worst = largest = moving = 0
    for n in cycles:
        wanted = [(b + 4 * now + f) / 6 for b, now, f in zip(moved[n - 1], moved[n], moved[n + 1])]
        worst = max(worst, math.dist(wanted, rows[n + DELAY][5:8]))
        largest = max(largest, math.dist(moved[n], points[n][1]))
        moving += rows[n][0:5] != rows[n - 1][0:5]
    print(f"{len(rows)} cycles, {moving} in motion, correction up to {1e3 * largest:.3f} um, joints off by {1e3 * worst:.4f} um at most")
    if moving < 1000 or largest < 2e-3:
        sys.exit("the program did not run")
    if worst > LEFT_MM:
        sys.exit("the joints are not where the model wants them")
    return 0


if __name__ == "__main__":
    sys.exit(main(*[os.path.abspath(argument) for argument in sys.argv[1:4]]))
