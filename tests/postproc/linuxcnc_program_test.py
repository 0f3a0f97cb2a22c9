"""LinuxCNC's simulated controller runs a corrected program with xyzac-trt-kins, and its joints stand where the model wants them.

linuxcnc_program_test.py TRUNNION SOURCE_DIR OUT. Needs linuxcnc-uspace and root; without them it ends with 77 (skipped). Every block
ends exactly (G61.1), those of the original wait a little:
  - the axes come to where the corrected words say; and at those stops

  - the joints are the nominal kinematics of the axes,
  - and the tip is where `trunnion evaluate` finds the workpiece: joint = r_from_w(A', C') p + d, p as the original says it.
"""

import csv, math, os, pathlib, shutil, sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "support"))
import simulated_control as control

WORD_MM, LEFT_MM = 1e-6, 0.15e-3  # of a word; of the tip: four decimals of three words and of two angles
STILL = 6  # cycles

PAUSE = "G4 P0.03"
PROGRAM = ["%", "G21 G90 G94 G61.1 G54", "G0 X0 Y0 Z60 A-10 C0", PAUSE, "G1 X30 Y10 Z40 A-25 C30 F3000", PAUSE,
           "X32 Y11 Z39 A-27 C34", PAUSE, "X20 Y25 A-45 C60", PAUSE, "Y30 Z35", PAUSE, "X-15 Y20 Z30 A-60 C100", PAUSE,
           "G3 X-25 Y30 I-10", PAUSE, "G1 X0 Y0 Z50 A-80 C-20", PAUSE, "M2", "%"]


def ends(lines):
    """Where a program's blocks end: [x, y, z, a, c], plain words, G90."""
    place, found = {}, []
    for line in lines:
        words = [w for w in line.split("(")[0].split() if w[0] in "XYZAC"]
        place.update({w[0]: float(w[1:]) for w in words})
        if words and len(place) == 5:
            found.append([place[letter] for letter in "XYZAC"])
    return found


def stops(rows):
    """Places where everything stood for some cycles."""
    found = []
    for n in range(STILL, len(rows)):
        stood = all(abs(x - y) < 1e-9 for x, y in zip(rows[n], rows[n - STILL]))
        if stood and (not found or max(abs(x - y) for x, y in zip(rows[n], found[-1])) > 1e-7):
            found.append(rows[n])
    return found


def main(trunnion, source, out):
    if why := control.missing("halsampler"):
        print(why)
        return 77
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    control.write(f"{out}/part.ngc", PROGRAM)
    machine, model = f"{source}/machines/seed-trunnion.toml", f"{source}/tests/golden/shared/model.json"
    control.write(f"{out}/job.toml", ["[work_offsets_mm]", "G54 = [0, 0, 0]"])
    done = control.sh(f"{trunnion} correct --machine {machine} --model {model} --job {out}/job.toml {out}/part.ngc -o {out}/sent.ngc")
    if done.returncode != 0:
        sys.exit(done.stderr)
    control.configure(out, kinematics="xyzac-trt-kins coordinates=XYZAC")
    control.write(f"{out}/run.py", [
        "import linuxcnc, time, subprocess",
        "linuxcnc.nmlfile = '/usr/share/linuxcnc/linuxcnc.nml'",
        "c, s = linuxcnc.command(), linuxcnc.stat()",
        "c.state(linuxcnc.STATE_ESTOP_RESET); c.wait_complete(20); c.state(linuxcnc.STATE_ON); c.wait_complete(20)",
        "c.home(-1); time.sleep(1); c.mode(linuxcnc.MODE_AUTO); c.wait_complete(20)",
        f"c.program_open('{out}/sent.ngc'); c.wait_complete(20)",
        "sampler = subprocess.Popen(['halsampler', '-n', '25000', 'samples.txt'])",
        "c.auto(linuxcnc.AUTO_RUN, 0); time.sleep(2)",
        "for i in range(600):",
        "    s.poll()",
        "    if s.interp_state == linuxcnc.INTERP_IDLE: break",
        "    time.sleep(0.1)",
        "time.sleep(0.5); sampler.terminate(); sampler.wait(20)"])
    control.run_controller(out)
    with open(f"{out}/samples.txt") as file:
        rows = [[float(x) for x in line.split()] for line in file if len(line.split()) == 10]
    stood = stops(rows)
    with open(f"{out}/sent.ngc") as file:
        sent = ends(file)
    original = ends(PROGRAM)
    missing = [end for end in sent if min(max(abs(x - y) for x, y in zip(end, r[:5])) for r in rows) > WORD_MM]
    kinematics = max(math.dist(control.on_table(s[0:3], s[3], s[4]), s[5:8]) for s in stood)
    # Ends of the original by the last stop that belongs to them: nearest in the five words.
    matched = [min(stood, key=lambda s: max(abs(x - y) for x, y in zip(end, s[:5]))) for end in original]
    with open(f"{out}/at.csv", "w") as file:
        file.write("A_deg,C_deg,x_mm,y_mm,z_mm\n")
        for end, s in zip(original, matched):
            file.write(",".join(repr(v) for v in (s[3], s[4], *control.on_table(end[0:3], s[3], s[4]))) + "\n")
    done = control.sh(f"{trunnion} evaluate --machine {machine} --model {model} --at {out}/at.csv -o {out}/d.csv")
    if done.returncode != 0:
        sys.exit(done.stderr)
    worst = largest = 0
    with open(f"{out}/d.csv") as file:
        for row, s in zip(csv.DictReader(file), matched):
            d = [1e-3 * float(row[k]) for k in ("dx_um", "dy_um", "dz_um")]
            wanted = [float(row[k]) + x for k, x in zip(("x_mm", "y_mm", "z_mm"), d)]
            worst = max(worst, math.dist(wanted, s[5:8]))
            largest = max(largest, math.hypot(*d))
    print(f"{len(rows)} cycles, {len(stood)} stops, {len(sent)} ends, {len(missing)} not reached; joints off the kinematics by "
          f"{1e6 * kinematics:.3f} nm; corrections up to {1e3 * largest:.3f} um, tip off the model by {1e3 * worst:.4f} um at most")
    if missing or len(sent) < len(original) or kinematics > WORD_MM or largest < 5e-3 or worst > LEFT_MM:
        sys.exit("the control does not go where the model wants it")
    return 0


if __name__ == "__main__":
    sys.exit(main(*[os.path.abspath(argument) for argument in sys.argv[1:4]]))
