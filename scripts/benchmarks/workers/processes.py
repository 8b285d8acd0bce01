"""Processes that are measured by turns: each waits, at rest, for a word to do some of its steps.

A worker reads a line of JSON, does what it says, and answers with one. Several ranks wait without
spinning, so that they do not disturb whoever is measured meanwhile.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

#: Where programs find the modules of the benchmarks.
HERE = Path(__file__).resolve().parents[1]
_TAG = 4242
_LAUNCHERS = ("OMPI_", "PMIX_", "PMI_", "SLURM_")


def environment(more=None):
    """Environment of a process that no launcher started; root may use mpirun."""
    env = {name: value for name, value in os.environ.items() if not name.startswith(_LAUNCHERS)}
    env |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    env["PYTHONPATH"] = os.pathsep.join(filter(None, (str(HERE), env.get("PYTHONPATH"))))
    return env | dict(more or {})


def launch(ranks, words):
    """Command that runs a Python module of the benchmarks on some ranks."""
    python = [sys.executable, str(HERE / words[0]), *words[1:]]
    if ranks == 1:
        return python
    return ["mpirun", "-q", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), *python]


class Worker:
    """A process that answers until it is closed: a command, see `serve`, with more variables."""

    def __init__(self, command, more=None):
        self._errors = tempfile.TemporaryFile("w+", errors="replace")
        self._process = subprocess.Popen(
            command, env=environment(more), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=self._errors, text=True,
        )  # fmt: skip
        self._command = command

    def ask(self, **words):
        self.tell(**words)
        return self.hear()

    def tell(self, **words):
        """Send a line, whose answer `hear` waits for."""
        try:
            self._process.stdin.write(json.dumps(words) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass

    def hear(self):
        """Return the answer to the line sent last."""
        for line in self._process.stdout:
            if line.startswith("{"):
                return json.loads(line)
        self._process.wait()
        self._errors.seek(0)
        raise SystemExit(
            f"benchmark: {' '.join(self._command)} ended with status {self._process.returncode}:\n"
            f"{self._errors.read()[-3000:]}"
        )

    def close(self):
        self._process.stdin.close()
        try:
            self._process.wait(30)
        except subprocess.TimeoutExpired:
            self._process.terminate()
            self._process.wait()
        self._process.stdout.close()
        self._errors.close()


def serve(comm, answer):
    """Answer until there is nothing more to read; collective.

    Rank 0 reads; `answer` is called with each line on every rank, and what rank 0 returns is sent.
    """
    while True:
        words = None
        if comm.rank == 0:
            line = sys.stdin.readline()
            words = json.loads(line) if line else None
            for rank in range(1, comm.size):
                comm.send(words, rank, _TAG)
        else:
            while not comm.Iprobe(0, _TAG):
                time.sleep(1e-3)
            words = comm.recv(source=0, tag=_TAG)
        if words is None:
            return
        found = answer(**words)
        if comm.rank == 0:
            print(json.dumps(found), flush=True)


def wait(comm):
    """Wait for all ranks without spinning; collective."""
    barrier = comm.Ibarrier()
    while not barrier.Test():
        time.sleep(1e-3)


def peak_memory():
    """Greatest memory of this process until now, in bytes (VmHWM)."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return 1024 * int(line.split()[1])
    return 0
