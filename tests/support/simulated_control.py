"""LinuxCNC's simulated controller without a display, for the tests that need a real control: configure, run a script of its
Python interface in it, take everything down again. Needs linuxcnc-uspace and root."""

import math, os, shutil, signal, subprocess, sys, time


def missing(*programs):
    """Why the controller cannot run here, in words; empty where it can."""
    lacking = [p for p in ("linuxcncsvr", "halcmd", "milltask", *programs) if shutil.which(p) is None]
    if lacking:
        return ", ".join(lacking) + " (LinuxCNC and its development files) wanted"
    return "" if os.geteuid() == 0 else "root is wanted"


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


def forget_old_memory():
    """Shared memory that an earlier controller left keeps the next from starting."""
    keys = {0x48414C32, 0x90280A48, 0x48484C34, *range(1001, 1006)}
    for kind in ("m", "s"):
        for line in sh(f"ipcs -{kind}").stdout.splitlines():
            words = line.split()
            if len(words) > 1 and words[0].startswith("0x") and int(words[0], 16) in keys:
                sh(f"ipcrm -{kind} {words[1]}")


def run_controller(out, seconds=120):
    """Starts what configure wrote, runs OUT/run.py in it, takes it down."""
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
