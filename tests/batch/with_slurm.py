#!/usr/bin/env python3
"""Runs a command on a Slurm cluster of this one machine.

    with_slurm.py COMMAND …

Starts munged, slurmctld and slurmd of its own in a scratch folder, on ports of its own, puts the configuration into
SLURM_CONF, runs the command, stops them and returns the command's exit status; 77 (skipped) where there is no Slurm, or
no right to start one (slurmd wants root).
"""
import contextlib
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

PROGRAMS = {name: shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")
            for name in ("munged", "slurmctld", "slurmd", "sinfo", "sbatch")}

CONFIGURATION = """\
ClusterName=trunnion
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,batch_sched_delay=0
MaxArraySize=10001
KillWait=1
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def wait_until(condition, what, seconds=60):
    for _ in range(seconds * 5):
        if condition():
            return
        time.sleep(0.2)
    raise RuntimeError(f"{what}: not within {seconds} s")


def main():
    if os.getuid() != 0 or None in PROGRAMS.values():
        print("no Slurm here, or not root: skipped (cmake/install-dependencies.sh fleet)")
        return 77
    with tempfile.TemporaryDirectory(prefix="tsl") as name, contextlib.ExitStack() as stack:
        folder = pathlib.Path(name)
        folder.chmod(0o755)  # munged wants its socket where all may reach it and nobody else write
        (folder / "state").mkdir()
        (folder / "spool").mkdir()
        (folder / "munge.key").write_bytes(os.urandom(128))
        (folder / "munge.key").chmod(0o600)
        host = socket.gethostname().split(".")[0]
        (folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=host, folder=folder, ports=free_ports(2), cpus=len(os.sched_getaffinity(0))))
        (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n")
        environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}

        def start(program, *words):
            log = stack.enter_context((folder / f"{program}.out").open("w"))
            process = subprocess.Popen([PROGRAMS[program], *words], env=environment, stdout=log, stderr=log,
                                       stdin=subprocess.DEVNULL)

            def stop():
                process.terminate()
                try:
                    process.wait(20)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()
            stack.callback(stop)
            return process

        def is_idle():
            found = subprocess.run([PROGRAMS["sinfo"], "-h", "-o", "%t"], env=environment, capture_output=True, text=True)
            return found.stdout.strip() == "idle"
        try:
            start("munged", "--foreground", f"--key-file={folder}/munge.key", f"--socket={folder}/munge.socket",
                  f"--pid-file={folder}/munge.pid", f"--seed-file={folder}/munge.seed", "--num-threads=2")
            wait_until((folder / "munge.socket").exists, "munged")
            start("slurmctld", "-D")
            start("slurmd", "-D", "-N", host)
            wait_until(is_idle, "a node that takes jobs")
        except RuntimeError as error:
            print(error)
            for log in ("munged.out", "slurmctld.out", "slurmctld.log", "slurmd.out", "slurmd.log"):
                if (folder / log).exists():
                    print(f"--- {log}\n{(folder / log).read_text(errors='replace')[-2000:]}")
            return 1
        return subprocess.run(sys.argv[1:], env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
