"""Text of a batch script: requests to the scheduler, and a run that continues until done."""

from __future__ import annotations

import re
import shlex
import string
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

from pgimp.running.stop import clock

# Fraction of a job's time by which it is stopped early; its least and greatest value in seconds.
_NOTICE_PART, _LEAST_NOTICE, _MOST_NOTICE = 0.05, 60.0, 300.0
_MODULE = "type module >/dev/null 2>&1 || . /etc/profile"
_SLURM_WORDS = {"submit": "sbatch", "cancel": "scancel", "number": "SLURM_JOB_ID"}
_PBS_WORDS = {"submit": "qsub", "cancel": "qdel", "number": "PBS_JOBID"}


class _Text(string.Template):
    """A template whose marks of variables occur in no shell script."""

    delimiter = "@@"


@dataclass(frozen=True)
class Job:
    """The run of a script, and its resources; texts have no control characters."""

    scheduler: str  #: ``slurm`` or ``pbs``.
    name: str  #: Name of the job; letters, digits and ``_.+-``.
    #: ranks, nodes: Number of ranks, and of nodes for them; 0 nodes leave the choice to the
    #: scheduler.
    ranks: int
    nodes: int
    seconds: float  #: Time limit of a job.
    #: account, partition: The account; the partition or queue. One word each, or empty for the
    #: cluster's default.
    account: str
    partition: str
    directives: Sequence[str]  #: Further options of ``sbatch`` or ``qsub``, verbatim.
    modules: Sequence[str]  #: Modules to load before the run.
    launcher: Sequence[str]  #: ``mpirun`` or ``srun`` with options.
    python: str  #: The interpreter with pgimp.
    folder: str  #: Absolute path of the folder to which case and output are relative.
    #: case, output: The case file and the run directory.
    case: str
    output: str
    changes: Sequence[str]  #: Changes to the case, as ``key.path=value``.
    file: str  #: Absolute path of the script; empty if it goes to the terminal.
    version: str  #: Version of pgimp.
    imports: Sequence[str] = ()  #: Python files that register materials.
    error: bool = False  #: Whether companions run first, for estimated errors.

    @property
    def notice(self) -> int:
        """Seconds between the request to stop and the end of the job's time."""
        part = min(max(_NOTICE_PART * self.seconds, _LEAST_NOTICE), _MOST_NOTICE)
        return int(min(part, 0.5 * self.seconds))


def write(job: Job) -> str:
    """Return the script of a job."""
    slurm = job.scheduler == "slurm"
    options = [f"--output={job.output}", "--resume", *(f"--set={one}" for one in job.changes)]
    options += [f"--import={one}" for one in job.imports] + ["--error"] * job.error
    modules = [f"module load {shlex.quote(name)} || fail 'no such module'" for name in job.modules]
    if modules:
        modules[:0] = ["# shellcheck disable=SC1091", _MODULE]
    texts = {
        "directives": "\n".join(_slurm(job) if slurm else _pbs(job)),
        "version": job.version,
        "notice": job.notice,
        "ranks": job.ranks,
        "file": shlex.quote(job.file),
        "folder": shlex.quote(job.folder),
        "output": shlex.quote(job.output),
        "python": shlex.quote(job.python),
        "launcher": shlex.join(job.launcher),
        "words": shlex.join([job.case, *options]),
        "modules": "".join(f"{line}\n" for line in modules),
        "seconds": int(job.seconds),
    }
    texts |= _SLURM_WORDS if slurm else _PBS_WORDS
    return _Text(_template(job.scheduler)).substitute(texts)


def _template(scheduler: str) -> str:
    """Return ``job.sh.in`` for a scheduler; lines that begin with ``@NAME`` are for NAME only."""
    text = files(__package__).joinpath("job.sh.in").read_text(encoding="utf-8")
    return re.sub(r"(?m)^@(\w+) (.*\n)", lambda m: m[2] if m[1] == scheduler else "", text)


def _slurm(job: Job) -> list[str]:
    """Directives of Slurm; of two of a kind the later counts, so the user's come last."""
    words = [f"--job-name={job.name}", f"--ntasks={job.ranks}"]
    if job.nodes:
        words.append(f"--nodes={job.nodes}")
        if job.ranks % job.nodes == 0:
            words.append(f"--ntasks-per-node={job.ranks // job.nodes}")
    words += [f"--time={clock(job.seconds)}", f"--signal=B:USR1@{job.notice}"]
    words += ["--requeue", "--open-mode=append", "--output=%x-%j.log"]
    if job.account:
        words.append(f"--account={job.account}")
    if job.partition:
        words.append(f"--partition={job.partition}")
    return [f"#SBATCH {word}" for word in [*words, *job.directives]]


def _pbs(job: Job) -> list[str]:
    """Directives of PBS; the nodes are chunks of cores, on a host each."""
    if job.nodes:
        least, more = divmod(job.ranks, job.nodes)
        sizes = [(more, least + 1), (job.nodes - more, least)]
        chunks = "+".join(f"{n}:ncpus={size}:mpiprocs={size}" for n, size in sizes if n)
        place = ["-l place=scatter"]
    else:
        chunks, place = f"{job.ranks}:ncpus=1:mpiprocs=1", []
    words = [f"-N {job.name}", "-S /bin/bash", f"-l select={chunks}", *place]
    words += [f"-l walltime={clock(job.seconds)}", "-j oe", "-r y"]
    if job.account:
        words.append(f"-A {job.account}")
    if job.partition:
        words.append(f"-q {job.partition}")
    return [f"#PBS {word}" for word in [*words, *job.directives]]
