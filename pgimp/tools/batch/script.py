"""The text of a batch script: what is asked of the scheduler, and a run that goes on until done."""

from __future__ import annotations

import shlex
import string
from collections.abc import Sequence
from dataclasses import dataclass

from pgimp.running.stop import clock

# Part of a job's time by which it is told to stop ahead of its end; at least, at most (seconds).
_NOTICE_PART, _LEAST_NOTICE, _MOST_NOTICE = 0.05, 60.0, 300.0


@dataclass(frozen=True)
class Job:
    """What a script is to run, and where; no text in it has control characters.

    Attributes
    ----------
    scheduler : str
        ``slurm`` or ``pbs``.
    name : str
        Of the job; letters, digits and ``_.+-``.
    ranks, nodes : int
        Number of ranks, and of nodes for them; 0 nodes leave the choice to the scheduler.
    seconds : float
        The most that the job may take at a time.
    account, partition : str
        Whom to charge; the partition or queue. One word each, or empty for the cluster's choice.
    directives : sequence of str
        More options of ``sbatch`` or ``qsub``, as the script is to have them.
    modules : sequence of str
        To be loaded before the run.
    launcher : sequence of str
        ``mpirun`` or ``srun`` with options.
    python : str
        The interpreter that has pgimp.
    folder : str
        Absolute path of the folder from which case and output are named.
    case, output : str
        The case file and the run directory.
    changes : sequence of str
        Changes to the case, as ``key.path=value``.
    file : str
        Absolute path of the script; empty if it goes to the terminal.
    version : str
        Of pgimp.
    imports : sequence of str
        Python files that register materials.
    """

    scheduler: str
    name: str
    ranks: int
    nodes: int
    seconds: float
    account: str
    partition: str
    directives: Sequence[str]
    modules: Sequence[str]
    launcher: Sequence[str]
    python: str
    folder: str
    case: str
    output: str
    changes: Sequence[str]
    file: str
    version: str
    imports: Sequence[str] = ()

    @property
    def notice(self) -> int:
        """Seconds before the end of the job's time at which the run is told to stop."""
        part = min(max(_NOTICE_PART * self.seconds, _LEAST_NOTICE), _MOST_NOTICE)
        return int(min(part, 0.5 * self.seconds))


def write(job: Job) -> str:
    """Return the script of a job.

    Parameters
    ----------
    job : Job
        What it is to do.
    """
    slurm = job.scheduler == "slurm"
    options = [f"--output={job.output}", "--resume", *(f"--set={one}" for one in job.changes)]
    options += [f"--import={one}" for one in job.imports]
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
    parts = _SLURM_PARTS if slurm else _PBS_PARTS
    texts |= {name: _Text(text).substitute(texts) for name, text in parts.items()}
    return _Text(_SCRIPT).substitute(texts)


def _slurm(job: Job) -> list[str]:
    """Directives of Slurm; of two of a kind the later counts, so that those asked for come last."""
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


_MODULE = "type module >/dev/null 2>&1 || . /etc/profile"


class _Text(string.Template):
    """A template whose variables are marked in a way that no shell script needs."""

    delimiter = "@@"


_SLURM_PARTS = {
    "submit": "sbatch",
    "cancel": "scancel",
    "number": "SLURM_JOB_ID",
    "story": """\
# @@notice seconds before its time is up, or up to a minute earlier, Slurm sends this script a
# signal, SIGUSR1, which it passes on. The run writes a checkpoint and ends with status 75; the job
# then goes back into the queue, under the same number, and goes on from there. So does a job whose
# node failed.""",
    "timer": "",
    "timed": "",
    "again": """\
if ! scontrol requeue "$SLURM_JOB_ID"; then
    say "cannot requeue the job; submit this script again to go on from the checkpoint"
    exit 75
fi
say 'requeued, to go on from the checkpoint'""",
}

_PBS_PARTS = {
    "submit": "qsub",
    "cancel": "qdel",
    "number": "PBS_JOBID",
    "story": """\
# @@notice seconds before its time is up the run is sent SIGUSR1. It writes a checkpoint and ends
# with status 75; this script then submits itself again, as a new job that goes on from there
# (putting the same job back, with qrerun, is for operators only).""",
    "timer": """\
# PBS has no signal ahead of its limit. SECONDS counts from the start of this script.
left=$((@@seconds - @@notice - SECONDS))
launcher=(timeout --foreground --preserve-status --signal=USR1 "$((left > 1 ? left : 1))"
    "${launcher[@]}")
""",
    "timed": """\
[ "$SECONDS" -lt "$left" ] || early=true
""",
    "again": """\
again=(qsub)
[ -z "${PGIMP_PYTHON:-}" ] || again+=(-v "PGIMP_PYTHON=$PGIMP_PYTHON")
if ! "${again[@]}" @@file; then
    say "cannot submit the next job from here; do so on a login node: qsub" @@file
fi
exit 75 # so that a job that waits for the success of this one does not start yet""",
}

_SCRIPT = r"""#!/bin/bash
@@directives
#
# Written by `pgimp batch` of pgimp @@version; submit it with @@submit.
#
# Takes a run to its end in as many jobs as that needs. A job goes on from the newest checkpoint.
@@story
# @@cancel ends it for good; the next submission goes on from the last checkpoint.

say() { printf 'batch: %s\n' "$*" >&2; }
fail() { say "$@"; exit 1; }

# The Python that has pgimp, where the nodes see it; the variable PGIMP_PYTHON names another.
python=${PGIMP_PYTHON:-@@python}
launcher=(@@launcher)
cd -- @@folder || fail "cannot go to the folder of the case"
output=@@output

# --- Signals ---

run=           # the launcher's process
signals=0      # how many came
early=false    # the one ahead of the limit did
cancelled=false
tell_run() {
    signals=$((signals + 1))
    if [ -n "$run" ] && [ "$signals" = 1 ]; then
        # Launchers lose signals while they start, so the run gets it until it ends.
        (while kill -s USR1 "$run"; do sleep 10; done) >/dev/null 2>&1 &
    fi
}
trap 'early=true; tell_run' USR1
trap 'cancelled=true; tell_run' TERM

# --- The run ---

@@{modules}set -u
[ -n "${@@number:-}" ] || fail "submit this script with @@submit"
[ -x "$python" ] || fail "there is no $python on $(uname -n); set PGIMP_PYTHON"
if "${launcher[0]}" --version 2>/dev/null | grep -q 'Open MPI'; then
    launcher+=(-q) # pgimp says itself what happens
fi
@@{timer}checkpoints() { ls -- "$output/checkpoints" 2>/dev/null; }
before=$(checkpoints)
"${launcher[@]}" -n @@ranks "$python" -m pgimp @@words </dev/null &
run=$!
if [ "$signals" != 0 ]; then
    signals=0
    tell_run
fi
# Not `wait` alone: a signal ends it, and bash may then have lost the status of the run.
while kill -0 "$run" 2>/dev/null; do sleep 1; done
trap '' USR1
status=0
wait "$run" || status=$?

# --- What next? ---

if [ "$status" -gt 128 ] && [ "$status" != 138 ] && ! "$cancelled"; then
    why="a rank was ended by signal $((status - 128))"
    [ "$status" != 137 ] || why="$why, as happens when memory runs out"
    say "$why; submit this script again to go on from the last checkpoint"
    [ ! -f "$output/log.txt" ] || printf 'batch: %s\n' "$why" >>"$output/log.txt"
elif [ "$status" != 0 ] && [ "$status" != 75 ] && [ "$status" != 138 ]; then
    say "the run ended with status $status; its message is above, and in $output/log.txt"
fi

@@{timed}stuck=$output/.batch-stuck # the last job got no further
case $status in
0) rm -f -- "$stuck"; exit 0 ;;
75) ;;
138) "$early" || exit 138 ;; # SIGUSR1 came before pgimp could take it
*) exit "$status" ;;
esac
if "$cancelled"; then
    say "cancelled, or out of time; @@submit it again to go on from the last checkpoint"
    exit 143
fi
if [ "$(checkpoints)" != "$before" ]; then
    rm -f -- "$stuck"
elif [ -e "$stuck" ]; then
    rm -f -- "$stuck"
    fail "no progress in two jobs, so there is no third; do they need more time than they have?"
elif ! mkdir -p -- "$output" || ! touch -- "$stuck"; then
    fail "cannot write to $output"
fi
@@again
"""
