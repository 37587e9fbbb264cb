"""A Slurm of one node on loopback, with ports, keys and folders of its own; gone with the test. Needs Debian's slurmctld, slurmd,
slurm-client and munge, and root (or the user that all of it runs as)."""
import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")


def find(program):
    return shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def missing():
    """What it lacks here, or nothing."""
    lacking = [program for program in PROGRAMS if not find(program)]
    return f"{', '.join(lacking)} not installed (Debian's slurmctld, slurmd, slurm-client, munge)" if lacking else ""


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Slurm:
    """`with Slurm(folder) as slurm`: subprocesses with slurm.environment reach it."""

    def __init__(self, folder, cpus=2):
        self.folder = pathlib.Path(folder)
        self.cpus = cpus
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf")}
        self.processes = {}

    def __enter__(self):
        self.folder.mkdir(parents=True)
        os.chmod(self.folder, 0o755)
        user, host = pwd.getpwuid(os.getuid()).pw_name, socket.gethostname().split(".")[0]
        for name in ("state", "spool", "log", "munge"):
            (self.folder / name).mkdir(mode=0o755)
        key = self.folder / "munge/key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o600)
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20
        (self.folder / "slurm.conf").write_text(f"""ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={self.folder}/munge/socket
CredType=cred/munge
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
SlurmctldLogFile={self.folder}/log/slurmctld.log
SlurmdLogFile={self.folder}/log/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
MinJobAge=600
KillWait=2
SlurmdTimeout=30
NodeName={host} NodeAddr=127.0.0.1 CPUs={self.cpus} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        self.start_munge()
        self.start("slurmctld", "-D", "-f", str(self.folder / "slurm.conf"))
        self.start("slurmd", "-D", "-f", str(self.folder / "slurm.conf"))
        self.wait_until(lambda: "idle" in self.ask("sinfo", "--noheader", "--format=%T") or "mixed" in self.ask("sinfo", "--noheader", "--format=%T"), "a node that is idle")
        return self

    def start_munge(self):
        munge = self.folder / "munge"
        self.start("munged", "--foreground", "--force", "--num-threads=2", f"--key-file={munge}/key", f"--socket={munge}/socket", f"--pid-file={munge}/pid", f"--seed-file={munge}/seed",
                   f"--log-file={munge}/log")
        self.wait_until(lambda: (munge / "socket").exists(), "munge's socket")

    def start(self, program, *arguments):
        log = open(self.folder / f"{program}.out", "ab")
        self.processes[program] = subprocess.Popen([find(program), *arguments], env=self.environment, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
        log.close()

    def end(self, program, how=signal.SIGTERM):
        process = self.processes.pop(program)
        process.send_signal(how)
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def restart_controller(self):
        self.end("slurmctld")
        time.sleep(2)
        self.start("slurmctld", "-D", "-f", str(self.folder / "slurm.conf"))

    def ask(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=60).stdout

    def wait_until(self, is_so, what, seconds=60):
        end = time.monotonic() + seconds
        while not is_so():
            if time.monotonic() > end:
                raise RuntimeError(f"slurm on loopback: no {what} in {seconds} s; {self.said()}")
            time.sleep(0.2)

    def said(self):
        return " | ".join(f"{p.name}: {p.read_text(errors='replace')[-800:]}" for p in [*self.folder.glob("*.out"), *self.folder.glob("log/*")])

    def __exit__(self, *_):
        if "slurmctld" in self.processes:
            self.ask("scancel", "--user", pwd.getpwuid(os.getuid()).pw_name)
        for program in ("slurmd", "slurmctld", "munged"):
            if program in self.processes:
                self.end(program)
