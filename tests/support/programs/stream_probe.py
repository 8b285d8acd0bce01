"""Every command on standard streams that are closed, full or read by nobody, without its work.

Called in a folder with ``case.yaml``, ``study.yaml`` and the run directories ``one`` and ``two``.
Each command runs in a fork of this process, which has imported what takes long; what is printed is
a line of JSON for each: command, condition, exit status, stderr, and the data file that it wrote.
"""

import json
import os
import sys
import tempfile

import matplotlib

import pgimp.__main__ as program
from pgimp import cli  # noqa: F401
from pgimp.commands import batch, bench, check, compare, doctor, init, plot, run, schema, study
from pgimp.utilities.doctor.finding import Finding

matplotlib.use("Agg")
WORDS = {
    "run": ["case.yaml"],
    "init": ["init"],
    "check": ["check", "case.yaml"],
    "study": ["study", "study.yaml"],
    "list": ["study", "study.yaml", "--list"],
    "plot": ["plot", "one", "--columns", "value_0", "-o", "figure.csv"],
    "batch": ["batch", "case.yaml", "--ranks=2", "--wall-time=1:00:00", "--script=-"],
    "compare": ["compare", "one", "two"],
    "bench": ["bench"],
    "doctor": ["doctor"],
    "schema": ["schema"],
    "help": ["--help"],
    "help-of": ["check", "--help"],
    "version": ["--version"],
    "wrong": ["schema", "--bogus"],
}
BENCH = {"particle_steps_per_second": 1.0, "phases": {}, "particles": 1, "steps": 1, "ranks": 1,
         "positions": "lattice", "error": {"velocity": 0.0, "stress": 0.0}, "cpu": "x"}  # fmt: skip


def fake_run(job, case):
    """Says lines as a run does, beside a file that it has open."""
    with open("data", "w") as data:
        data.write("data\n")
        for _ in range(3):
            job.log.say("a line of the run " * 20)
        data.flush()
        print("said by a library", file=sys.stderr)
    return True


run.Job.run = fake_run
check.report = lambda case, *more: print(f"{case.title}: valid")
bench.measure = lambda *args: BENCH
bench._table = str
doctor._examine = lambda: iter([Finding("machine", "is one")])
study._run_all = lambda plan, folder, outcomes, again, log, held: log.say("ran")
MODULES = (batch, compare, init, plot, schema)


def null_end():
    """The end of a pipe that nobody reads."""
    read, write = os.pipe()
    os.close(read)
    return write


def arrange(condition, said):
    """Let the standard streams be as the condition names them; stderr goes to `said` else."""
    os.dup2(said, 2)
    if condition == "full":
        os.dup2(os.open("/dev/full", os.O_WRONLY), 1)
    elif condition == "nobody":
        os.dup2(null_end(), 1)
    elif condition == "full-both":
        for number in (1, 2):
            os.dup2(os.open("/dev/full", os.O_WRONLY), number)
    else:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        for number, name in enumerate(("stdin", "stdout", "stderr")):
            if str(number) in condition:
                os.close(number)
                setattr(sys, name, None)  # as the interpreter does when it starts


def child(words, condition, said):
    arrange(condition, said)
    sys.argv = ["pgimp", *words]
    try:
        status = program.main()
    except SystemExit as left:
        status = left.code or 0
    for stream in (sys.stdout, sys.stderr):  # as the interpreter does when it leaves
        try:
            if stream is not None:
                stream.flush()
        except (OSError, ValueError):
            status = 120
    os._exit(status)


for name, words in WORDS.items():
    for condition in ("full", "full-both", "nobody", "closed 1", "closed 2", "closed 012"):
        if os.path.exists("data"):
            os.unlink("data")
        with tempfile.TemporaryFile() as said:
            number = os.dup(said.fileno())
            os.set_inheritable(number, True)
            sys.stdout.flush()
            process = os.fork()
            if process == 0:
                child(words, condition, number)
            status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
            os.close(number)
            said.seek(0)
            data = open("data").read() if os.path.exists("data") else None
            print(json.dumps([name, condition, status, said.read().decode(), data]))
