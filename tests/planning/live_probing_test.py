"""From plan to closure without a hand in between, in LinuxCNC's simulated controller with a simulated touch: plan, probe,
import, identify, close.

live_probing_test.py TRUNNION SOURCE_DIR OUT. Needs linuxcnc-uspace, -dev, and root; without them it ends with 77 (skipped).
A realtime component knows the faces on the table and the errors of the rotary axes as exact rotations, and trips when the
ball meets a face. A stops too early in proportion to its angle, C's axis wobbles and its centre moves; and C has a backlash,
of which nobody tells the program.
"""

import csv, json, math, os, pathlib, shutil, sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "support"))
import simulated_control as control

EAA_PER_RAD, EAC_RAD, EXC_MM, BACKLASH_RAD = 22e-6, 9e-6, 3e-3, 40e-6
FEED_MM_PER_MIN, STANDOFF_MM = 20, 0.25
CYCLE_MM = FEED_MM_PER_MIN / 60e3  # the control knows no place between two cycles
SIGMA_UM = 1e3 * CYCLE_MM * math.sqrt(2 / 12)  # that rounding and a trigger as uncertain, so that the one is noise as well
LATERAL_MM, DEPTH_MM = 3, 2

COMPONENT = """component simulated_touch "A probe and the faces on a table whose rotary axes err";
pin in float x; pin in float y; pin in float z; pin in float a; pin in float c;
pin out bit touched;
variable double c_before;
variable double sense = 1;
variable unsigned drawn = 1;
variable double early;
function _ fp;
license "GPL";
;;
#include <rtapi_math.h>
static const double face[][6] = {
%(faces)s
};
static void about_x(double t, double *p) {
  double across = cos(t) * p[1] - sin(t) * p[2];
  p[2] = sin(t) * p[1] + cos(t) * p[2];
  p[1] = across;
}
FUNCTION(_) {
  double rad = 3.14159265358979323846 / 180, ca, cc, p[3], u, v;
  unsigned k;
  int met = 0;
  if (c > c_before + 1e-9) sense = 1;
  if (c < c_before - 1e-9) sense = -1;
  c_before = c;
  ca = a * rad;
  cc = c * rad;
  p[0] = x; p[1] = y; p[2] = z;  /* back from the slides to the part: A, C's centre, C's axis, C */
  about_x(-(ca + %(eaa)r * ca), p);
  p[0] -= %(exc)r * cos(cc);
  about_x(-%(eac)r * sin(cc), p);
  cc += sense * %(backlash)r / 2;
  u = cos(cc) * p[0] + sin(cc) * p[1];
  v = -sin(cc) * p[0] + cos(cc) * p[1];
  p[0] = u; p[1] = v;
  for (k = 0; k < sizeof face / sizeof face[0]; k++) {
    const double *f = face[k];
    double d[3] = {p[0] - f[0], p[1] - f[1], p[2] - f[2]};
    double h = d[0] * f[3] + d[1] * f[4] + d[2] * f[5] - %(radius)r;
    double s = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - (h + %(radius)r) * (h + %(radius)r);
    if (h <= early && h > -%(depth)r && s < %(lateral)r * %(lateral)r) met = 1;
  }
  if (touched && !met) {  /* for the next touch */
    drawn = drawn * 1664525u + 1013904223u;
    early = %(cycle)r * drawn / 4294967296.0;
  }
  touched = met;
}
"""


def rotation_x(t, p):
    return [p[0], math.cos(t) * p[1] - math.sin(t) * p[2], math.sin(t) * p[1] + math.cos(t) * p[2]]


def rotation_z(t, p):
    return [math.cos(t) * p[0] - math.sin(t) * p[1], math.sin(t) * p[0] + math.cos(t) * p[1], p[2]]


def on_machine(p, a, c):
    """Where a point of the part comes to, C's backlash aside."""
    p = rotation_x(EAC_RAD * math.sin(c), rotation_z(c, p))
    p = [p[0] + EXC_MM * math.cos(c), p[1], p[2]]
    return rotation_x(a + EAA_PER_RAD * a, p)


def deviation(p, a, c):
    """Of a point of the part at (a, c), which stood at p when the axes were at their reference pose: mm in R."""
    there = [p[0] - EXC_MM, p[1], p[2]]  # in the part's own frame: the machine's errors at (0, 0) undone
    real, nominal = on_machine(there, a, c), rotation_x(a, rotation_z(c, p))
    return [x - y for x, y in zip(real, nominal)]


def main(trunnion, source, out):
    if why := control.missing("halcompile"):
        print(why)
        return 77
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)

    def run(command):
        done = control.sh(command, cwd=out)
        if done.returncode != 0:
            sys.exit(command + ": " + done.stderr + done.stdout)
        return done.stdout

    with open(f"{source}/machines/seed-trunnion.toml") as file:
        text = file.read()
    with open(f"{out}/machine.toml", "w") as file:
        file.write(text.replace("sigma_um = 0.175", f"sigma_um = {SIGMA_UM:.4f}"))
    run(f"{trunnion} plan --machine machine.toml --nc linuxcnc --feed {FEED_MM_PER_MIN} --standoff {STANDOFF_MM} -o plan.csv")

    with open(f"{out}/plan.csv") as file:
        rows = list(csv.DictReader(file))
    faces = {r["point"]: [float(r[k]) for k in ("x_mm", "y_mm", "z_mm")] + [-float(r[k]) for k in ("nx", "ny", "nz")]
             for r in rows if float(r["A_deg"]) == 0 and float(r["C_deg"]) == 0}
    assert set(faces) == {r["point"] for r in rows}, "every spot stands in the reference pose"
    table = ",\n".join("{" + ", ".join(repr(v) for v in face) + "}" for face in faces.values())
    control.write(f"{out}/simulated_touch.comp", [COMPONENT % dict(
        faces=table, eaa=EAA_PER_RAD, exc=EXC_MM, eac=EAC_RAD, backlash=BACKLASH_RAD, radius=3.0, depth=float(DEPTH_MM),
        lateral=float(LATERAL_MM), cycle=CYCLE_MM)])
    run("halcompile --install simulated_touch.comp")

    control.configure(out, kinematics="trivkins coordinates=XYZAC", velocity=1000, acceleration=20000,
                   components=["loadrt simulated_touch"], functions=["simulated-touch.0"],
                   nets=[f"net j{n} => simulated-touch.0.{axis}" for n, axis in enumerate("xyzac")] +
                        ["net touched simulated-touch.0.touched => motion.probe-input"])
    control.write(f"{out}/run.py", [
        "import linuxcnc, time, sys",
        "linuxcnc.nmlfile = '/usr/share/linuxcnc/linuxcnc.nml'",
        "c, s, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()",
        "c.state(linuxcnc.STATE_ESTOP_RESET); c.wait_complete(20); c.state(linuxcnc.STATE_ON); c.wait_complete(20)",
        "c.home(-1); time.sleep(1); c.mode(linuxcnc.MODE_AUTO); c.wait_complete(20)",
        f"c.program_open('{out}/plan.ngc'); c.wait_complete(20)",
        "c.auto(linuxcnc.AUTO_RUN, 0); time.sleep(2)",
        "while True:",
        "    s.poll(); error = errors.poll()",
        "    if error: sys.exit(f'{error} at line {s.motion_line}')",
        "    if s.interp_state == linuxcnc.INTERP_IDLE: break",
        "    time.sleep(0.05)"])
    control.run_controller(out, seconds=2400)

    print(run(f"{trunnion} import probe-log plan.log --machine machine.toml -o read.csv"), end="")
    run(f"{trunnion} identify --machine machine.toml --observations read.csv -o first.json")
    said = json.loads(run(f"{trunnion} close --machine machine.toml --observations read.csv -o closed --json"))
    with open(f"{out}/closed/closure.json") as file:
        closure = json.load(file)
    print(closure["verdict"], [e["id"] for e in closure["effects"]])
    assert said["verdict"] == closure["verdict"]
    assert [e["id"] for e in closure["effects"]] == ["backlash:C"], closure["effects"]
    with open(f"{out}/closed/model.json") as file:
        effects = {e["id"]: e for e in json.load(file)["effects"]}
    (width,) = effects["backlash:C"]["parameters"].values()
    scale = {"urad": 1e-6, "rad": 1}[width["unit"]]
    off = abs(abs(width["value"]) * scale - BACKLASH_RAD)
    print(f"backlash {width['value']:.2f} +- {width['std']:.2f} {width['unit']}, made with {1e6 * BACKLASH_RAD:.2f} urad")
    assert off < 4 * width["std"] * scale and width["std"] * scale < BACKLASH_RAD / 20

    # Points on the table's axis, where C's backlash does nothing.
    places = [(a, c, h) for a in (-85, -50, -20) for c in (15, 100, 200, 310) for h in (20, 120)]
    with open(f"{out}/at.csv", "w") as file:
        file.write("A_deg,C_deg,x_mm,y_mm,z_mm\n")
        for a, c, h in places:
            file.write(",".join(repr(v) for v in (a, c, *rotation_x(math.radians(a), [0, 0, h]))) + "\n")
    worst = largest = 0
    run(f"{trunnion} evaluate --machine machine.toml --model closed/model.json --at at.csv -o d.csv")
    with open(f"{out}/d.csv") as file:
        for (a, c, h), row in zip(places, csv.DictReader(file)):
            wanted = deviation([0, 0, h], math.radians(a), math.radians(c))
            found = [1e-3 * float(row[k]) for k in ("dx_um", "dy_um", "dz_um")]
            worst = max(worst, math.dist(wanted, found))
            largest = max(largest, math.hypot(*wanted))
    print(f"map: deviations up to {1e3 * largest:.2f} um, found within {1e3 * worst:.2f} um")
    assert largest > 3e-3 and worst < 0.5e-3
    return 0


if __name__ == "__main__":
    sys.exit(main(*[os.path.abspath(argument) for argument in sys.argv[1:4]]))
