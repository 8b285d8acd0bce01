"""``pgimp batch``: writes a script for Slurm or PBS that completes a run, job by job."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from pathlib import Path

from pgimp.case.load import load
from pgimp.errors import UsageError, explain
from pgimp.io.rundir.ownfiles import RUN
from pgimp.io.rundir.runinfo import installed
from pgimp.mpi.comm import Serial
from pgimp.physics.materials.registry import imported
from pgimp.running.stop import wall_time
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.geometry import share
from pgimp.scene.scene import Scene
from pgimp.solver.start.validate_stages import look_ahead
from pgimp.storage import atomic
from pgimp.storage.plain import read_plain
from pgimp.utilities.accuracy.accompany import foreseen
from pgimp.utilities.accuracy.forecast import foretold
from pgimp.utilities.batch.script import Job, write

_WORD = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+:@/-]*", re.ASCII)
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.+-]{0,62}", re.ASCII)
_LAUNCHERS = ("mpirun", "mpiexec", "srun")
_MAX_COUNT = 10_000_000
_LARGEST = 1 << 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    add = parser.add_argument
    add("case", metavar="CASE.yaml", type=_line, help="the case file")
    add("--ranks", metavar="N", type=_count, required=True, help="number of ranks")
    add("--nodes", metavar="N", type=_count, default=0, help="number of nodes for them")
    add(
        "--wall-time",
        metavar="HH:MM:SS",
        type=wall_time,
        required=True,
        help="time limit of a job, also D-HH:MM:SS; a run that takes longer goes on in another job",
    )
    add("--scheduler", choices=("slurm", "pbs"), default="slurm", help="default: slurm")
    add("--account", metavar="NAME", type=_word, help="whom to charge")
    add("--partition", metavar="NAME", type=_word, help="the partition or queue")
    add(
        "--module",
        metavar="NAME",
        type=_word,
        action="append",
        default=[],
        help="a module to load first, such as that of the MPI library; repeatable",
    )
    add(
        "--launcher",
        metavar="WORDS",
        type=_launcher,
        default="mpirun",
        help="mpirun (the default), mpiexec or srun, with its options in the same quotes",
    )
    add(
        "--extra",
        metavar="OPTION",
        type=_line,
        action="append",
        default=[],
        help="another option of sbatch or qsub, such as --extra=--mem=0; repeatable",
    )
    add("--job-name", metavar="NAME", type=_name, help="default: the name of the case")
    add(
        "-o",
        "--output",
        metavar="DIR",
        type=_line,
        help="the run directory (default: the case's name with .out, in this folder)",
    )
    add(
        "--set",
        metavar="KEY.PATH=VALUE",
        type=_line,
        action="append",
        default=[],
        help="change a value of the case; repeatable",
    )
    add(
        "--script",
        metavar="FILE",
        type=_line,
        help="the script (default: the job's name with .sh, in this folder); - prints it",
    )
    add("--error", action="store_true", help="run companions first, as pgimp --error does")
    add("--overwrite", action="store_true", help="replace the script if there is one")


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        0.

    Raises
    ------
    CaseError, UsageError
        If the case or the command line is wrong, or the script cannot be written; there is then no
        script.
    """
    printed = args.script == "-"
    if args.nodes > args.ranks:
        raise UsageError(f"{args.nodes} nodes for {args.ranks} ranks: no node may be without one")
    if args.scheduler == "pbs" and os.path.basename(args.launcher[0]) == "srun":
        raise UsageError("srun is Slurm's launcher; with PBS use mpirun or mpiexec")
    if args.scheduler == "pbs" and printed:
        raise UsageError("a PBS script submits itself again and must know its file: name it")
    folder, python = os.getcwd(), sys.executable
    for what, path in ("folder", folder), ("Python", python):
        if not path.isprintable():
            raise UsageError(f"the path of this {what} cannot be written in a script: {path!r}")
    notes = _examine(args)
    name = args.job_name or _job_name(args.case)
    script = Path(args.script or f"{name}.sh")
    job = Job(
        scheduler=args.scheduler,
        name=name,
        ranks=args.ranks,
        nodes=args.nodes,
        seconds=args.wall_time,
        account=args.account or "",
        partition=args.partition or "",
        directives=[re.sub(r"^#(SBATCH|PBS)\s+", "", one) for one in args.extra],
        modules=args.module,
        launcher=args.launcher,
        python=python,
        folder=folder,
        # A name that begins with a dash would be an option.
        case=f"./{args.case}" if args.case.startswith("-") else args.case,
        output=args.output or f"{Path(args.case).stem}.out",
        changes=args.set,
        file="" if printed else os.path.abspath(script),
        version=installed("pgimp") or "unknown",
        imports=imported,
        error=args.error,
    )
    notes += foretold(Path(job.output), args.ranks, args.wall_time)
    if (Path(job.output) / RUN).exists():
        notes.append(f"{job.output} holds a run already; the job will go on with it")
    if printed:
        print(write(job), end="")
    else:
        _save(script, write(job), args.overwrite)
        submit = "sbatch" if job.scheduler == "slurm" else "qsub"
        print(f"submit it with: {submit} {shlex.quote(str(script))}")
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return 0


def _examine(args: argparse.Namespace) -> list[str]:
    """Raise errors that would stop the run before its first step; return notes."""
    case = load(args.case, args.set)
    scenes = [Scene(each) for each in case.stages]
    if case.time.stages:
        look_ahead(scenes)
    scene = scenes[0]
    share(scene.case, Serial())
    _, _, notes = count_particles(scene, Serial())
    layers = scene.domain.frame.vertices[0] // (scene.settings.vertices - 1)
    notes += foreseen(case)
    if args.ranks > layers:
        notes.append(f"the grid has layers for {layers} ranks; the others stand idle")
    return notes


def _job_name(case: str) -> str:
    """Make a job's name from the name of the case."""
    name = re.sub(r"[^A-Za-z0-9_.+-]+", "-", Path(case).stem, flags=re.ASCII)[:50]
    return name if _NAME.fullmatch(name) else f"pgimp{name}"


def _save(path: Path, text: str, overwrite: bool) -> None:
    try:
        if path.exists() and not overwrite and read_plain(path, _LARGEST) != text.encode():
            raise UsageError(f"there is a {path}; add --overwrite or name another with --script")
        atomic.write(path, text)
        path.chmod(0o755 & ~_umask())
    except OSError as error:
        raise UsageError(f"cannot write the script {path}: {explain(error)}") from error


def _umask() -> int:
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def _line(text: str) -> str:
    """Text that a script may contain; everything but control characters can be quoted."""
    if not text or not text.isprintable():
        raise argparse.ArgumentTypeError(f"{text!r} cannot be written in a script")
    return text


def _word(text: str) -> str:
    if not _WORD.fullmatch(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no name: letters, digits and _.+:@/- only")
    return text


def _name(text: str) -> str:
    if not _NAME.fullmatch(text):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no name of a job: a letter, then at most 62 letters, digits and _.+-"
        )
    return text


def _count(text: str) -> int:
    if not text.isdecimal() or not text.isascii() or not 0 < int(text[:9]) <= _MAX_COUNT:
        raise argparse.ArgumentTypeError(f"{text!r} is no number from 1 to {_MAX_COUNT}")
    return int(text)


def _launcher(text: str) -> list[str]:
    try:
        words = shlex.split(_line(text))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r}: {error}") from None
    if not words or os.path.basename(words[0]) not in _LAUNCHERS:
        raise argparse.ArgumentTypeError(f"{text!r} must begin with {', '.join(_LAUNCHERS)}")
    return words
