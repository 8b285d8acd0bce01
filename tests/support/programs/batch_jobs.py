"""Stand-ins for the programs that a batch script calls, and jobs that run on them."""

import json
import os
import subprocess
import time
from pathlib import Path

from processes import clean_env

from pgimp.cli import main

ASKED = ["--ranks", "2", "--wall-time", "0:02:00"]

# Stand-ins: each notes its words in the file `calls`.
NOTE = """#!/usr/bin/env -S python3 -IS
import json, os, signal, sys, time
with open(os.environ["CALLS"], "a") as calls:
    print(json.dumps([os.path.basename(sys.argv[0]), *sys.argv[1:]]), file=calls)
"""
MPIRUN = """#!/bin/bash
[ "$1" != --version ] || { echo "mpirun (Open MPI) 4.1.4"; exit; }
while [ "$1" != -n ]; do shift; done
shift 2
exec "$@"
"""
# Ends as PLAN says: at once with a status, or after SIGUSR1 with a checkpoint, if it gets one.
PYTHON = (
    NOTE
    + """
came = []
signal.signal(signal.SIGUSR1, lambda *_: came.append(1))
plan = os.environ["PLAN"].split()
open(os.environ["CALLS"] + ".up", "w").close()
if "deaf" in plan:
    time.sleep(0.5)
    came.clear()
folder = [word for word in sys.argv if word.startswith("--output=")][0][len("--output="):]
while "waits" in plan and not came:
    time.sleep(0.01)
if "checkpoint" in plan:
    os.makedirs(folder + "/checkpoints", exist_ok=True)
    open(folder + f"/checkpoints/step-{time.time_ns()}.h5", "w").close()
if plan[-1] == "killed":
    signal.signal(signal.SIGUSR1, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGUSR1)
os._exit(int(plan[-1]))  # at the interpreter's own exit SIGUSR1 would kill it
"""
)
ASKS = NOTE + 'sys.exit(int(os.environ.get("REFUSED", "0")))\n'
MODULE = NOTE + 'open(os.environ["CALLS"] + ".up", "w").close()\ntime.sleep(0.3)\n'
SLEEP = "#!/bin/sh\nexec {sleep} 0.05\n"
STAND_INS = {
    "mpirun": MPIRUN,
    "python": PYTHON,
    "scontrol": ASKS,
    "qsub": ASKS,
    "module": MODULE,
    "sleep": SLEEP.format(sleep="/bin/sleep"),
}


class Jobs:
    """Jobs of one script in `folder`, called from elsewhere."""

    def __init__(self, folder, elsewhere):
        self.folder, self.elsewhere = folder, elsewhere
        self.log = elsewhere / "calls"
        bin = elsewhere / "bin"
        bin.mkdir()
        for name, text in STAND_INS.items():
            (bin / name).write_text(text)
            (bin / name).chmod(0o755)
        self.env = clean_env(
            {
                "PATH": f"{bin}:{os.environ['PATH']}",
                "CALLS": str(self.log),
                "PGIMP_PYTHON": str(bin / "python"),
                "SLURM_JOB_ID": "7",
                "PBS_JOBID": "7.here",
            }
        )

    def __call__(self, *words):
        assert main(["batch", "blocks.yaml", *ASKED, *words]) == 0
        return self

    def run(self, plan, send=None, **env):
        """Run the script, send it a signal as soon as the run is up; its status and messages."""
        up = Path(f"{self.log}.up")
        for path in self.log, up:
            path.unlink(missing_ok=True)
        process = subprocess.Popen(
            ["bash", str(self.folder / "blocks.sh")],
            env=self.env | {"PLAN": plan} | env,
            cwd=self.elsewhere,
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            if send is not None:
                end = time.monotonic() + 20
                while not up.exists() and time.monotonic() < end:
                    time.sleep(0.01)
                process.send_signal(send)
            _, err = process.communicate(timeout=30)
        finally:
            process.kill()
        return process.returncode, err

    @property
    def calls(self):
        return [json.loads(line) for line in self.log.read_text().splitlines()]

    @property
    def requeued(self):
        return ["scontrol", "requeue", "7"] in self.calls
