"""The real control with the component loaded: every sampled joint is where the model wants it.

linuxcnc_live_test.py TRUNNION SAMPLES_CALIBRATE OUT. Needs linuxcnc-uspace, -dev, and root to install the module; without them
it ends with 77 (skipped). A five-axis program runs in the simulated controller; axis commands and joints are sampled every
servo cycle. LinuxCNC's joints come two cycles after the axes, smoothed (before + 4 now + after) / 6.
"""

import csv, math, os, shutil, signal, subprocess, sys, time

LEFT_MM = 0.05e-3
DELAY = 2


def sh(command, **more):
    return subprocess.run(command, shell=True, text=True, capture_output=True, **more)


def write(path, lines):
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n")


def configure(out, kinematics="trunnion_kins coordinates=XYZAC", velocity=100, acceleration=500, components=(), functions=(), nets=()):
    """Writes INI and HAL; `components`, `functions` of the servo thread and `nets` come after LinuxCNC's own."""
    ini = ["[EMC]", "VERSION=1.1", "[TASK]", "TASK=milltask", "CYCLE_TIME=0.01", "[RS274NGC]", "PARAMETER_FILE=v.var",
           "[EMCMOT]", "EMCMOT=motmod", "SERVO_PERIOD=1000000", "COMM_TIMEOUT=1", "[EMCIO]", "EMCIO=io", "CYCLE_TIME=0.1",
           "TOOL_TABLE=t.tbl", "[KINS]", f"KINEMATICS={kinematics}", "JOINTS=5", "[TRAJ]",
           "COORDINATES=XYZAC", "LINEAR_UNITS=mm", "ANGULAR_UNITS=degree", "DEFAULT_LINEAR_VELOCITY=50",
           f"MAX_LINEAR_VELOCITY={velocity}", f"MAX_LINEAR_ACCELERATION={acceleration}", "NO_FORCE_HOMING=1"]
    for joint, axis in enumerate("XYZAC"):
        for section in (f"AXIS_{axis}", f"JOINT_{joint}"):
            ini += [f"[{section}]", "MIN_LIMIT=-9999", "MAX_LIMIT=9999", f"MAX_VELOCITY={velocity}",
                    f"MAX_ACCELERATION={acceleration}"]
        ini += [f"TYPE={'ANGULAR' if axis in 'AC' else 'LINEAR'}", "HOME=0", "FERROR=100", "MIN_FERROR=100",
                "HOME_SEARCH_VEL=0", "HOME_LATCH_VEL=0", "HOME_SEQUENCE=0"]
    write(f"{out}/f.ini", ini)
    write(f"{out}/v.var", [])
    write(f"{out}/t.tbl", ["T1 P1 Z50"])
    hal = [f"loadrt {kinematics}", "loadrt tpmod", "loadrt homemod",
           "loadrt motmod servo_period_nsec=1000000 num_joints=5", "loadrt sampler depth=30000 cfg=ffffffffff",
           *components, "addf motion-command-handler servo-thread", "addf motion-controller servo-thread",
           "addf sampler.0 servo-thread", *(f"addf {function} servo-thread" for function in functions)]
    hal += [f"net j{n} joint.{n}.motor-pos-cmd => joint.{n}.motor-pos-fb" for n in range(5)]
    hal += [f"net a{n} axis.{axis}.pos-cmd => sampler.0.pin.{n}" for n, axis in enumerate("xyzac")]
    hal += [f"net q{n} joint.{n}.pos-cmd => sampler.0.pin.{n + 5}" for n in range(5)]
    hal += ["net e iocontrol.0.user-enable-out iocontrol.0.emc-enable-in",
            "net tp iocontrol.0.tool-prepare iocontrol.0.tool-prepared",
            "net tc iocontrol.0.tool-change iocontrol.0.tool-changed",
            *nets]
    if "trivkins" not in kinematics:
        hal.append(f"net tlo motion.tooloffset.z => {kinematics.split()[0]}.tool-offset")
    write(f"{out}/f.hal", hal)
    write(f"{out}/run.py", [
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


def forget_old_memory():
    """Shared memory that an earlier controller left keeps the next from starting."""
    keys = {0x48414C32, 0x90280A48, 0x48484C34, *range(1001, 1006)}
    for kind in ("m", "s"):
        for line in sh(f"ipcs -{kind}").stdout.splitlines():
            words = line.split()
            if len(words) > 1 and words[0].startswith("0x") and int(words[0], 16) in keys:
                sh(f"ipcrm -{kind} {words[1]}")


def run_controller(out, seconds=120):
    environment = dict(os.environ, RTAPI_UID="65534", RTAPI_FIFO_PATH=f"{out}/fifo/f", HOME=f"{out}/home")
    for folder in ("fifo", "home"):
        os.makedirs(f"{out}/{folder}", exist_ok=True)
        os.chmod(f"{out}/{folder}", 0o777)
    os.chmod(out, 0o777)
    own = dict(cwd=out, env=environment)
    forget_old_memory()
    quiet = dict(start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **own)
    server = subprocess.Popen(["linuxcncsvr", "-ini", "f.ini"], **quiet)
    task = None
    try:
        time.sleep(1)
        sh("timeout 20 halcmd loadusr -Wn iocontrol io -ini f.ini >io.log 2>&1", **own)
        loaded = sh("timeout 30 halcmd -i f.ini -f f.hal >hal.log 2>&1", **own)
        if loaded.returncode != 0:
            sys.exit("halcmd: " + loaded.stderr + loaded.stdout)
        task = subprocess.Popen(["milltask", "-ini", "f.ini"], **quiet)
        time.sleep(2)
        sh("timeout 10 halcmd start", **own)
        program = sh(f"timeout {seconds} /usr/bin/python3 run.py >run.log 2>&1", **own)
        if program.returncode != 0:
            sys.exit("program: " + program.stderr + program.stdout)
    finally:
        sh("timeout 10 halcmd stop", **own)
        for process in (task, server):
            if process is not None:
                os.killpg(process.pid, signal.SIGKILL)  # it forks: its own group and nobody else's
        sh("timeout 20 halcmd unload all", **own)
        for process in (task, server):
            if process is not None:
                process.wait(5)


def on_table(w, a, c):
    a, c = math.radians(a), math.radians(c)
    x, y = math.cos(c) * w[0] - math.sin(c) * w[1], math.sin(c) * w[0] + math.cos(c) * w[1]
    return [x, math.cos(a) * y - math.sin(a) * w[2], math.sin(a) * y + math.cos(a) * w[2]]


def main(trunnion, calibrate, out):
    for program in ("linuxcncsvr", "halcompile", "halcmd", "halsampler"):
        if shutil.which(program) is None or os.geteuid() != 0:
            print("LinuxCNC, its development files and root are wanted")
            return 77
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    machine = f"{calibrate}/machine.toml"
    for command in (f"{trunnion} identify --machine {machine} --observations {calibrate}/replica.csv -o {out}/model.json",
                    f"{trunnion} tables --machine {machine} --model {out}/model.json --controller linuxcnc -o {out}/set",
                    f"cd {out}/set/kinematics && halcompile --install trunnion_kins.comp"):
        done = sh(command)
        if done.returncode != 0:
            sys.exit(command + ": " + done.stderr + done.stdout)
    configure(out)
    run_controller(out)

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
        points[n] = (turned, on_table(w, *turned))
    with open(f"{out}/at.csv", "w") as file:
        file.write("A_deg,C_deg,x_mm,y_mm,z_mm\n")
        for (a, c), p in points.values():
            file.write(",".join(repr(v) for v in (min(a, 0.0), c, *p)) + "\n")
    done = sh(f"{trunnion} evaluate --machine {machine} --model {out}/model.json --at {out}/at.csv -o {out}/d.csv")
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
