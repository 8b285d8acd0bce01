"""The end of a run: summary, notes of what may be wrong, accuracy, and figures for run.json."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.case.outflow import exits_of
from pgimp.io.results.reader import Run
from pgimp.io.rundir.rundir import RunDirectory
from pgimp.running.accuracy.find import of_run
from pgimp.running.accuracy.rules import line
from pgimp.running.log import Log
from pgimp.running.progress import duration

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.running.recorder import Recorder
    from pgimp.solver.simulation import Simulation

#: Fraction of the mass past a wall above which a note is shown.
_NEGLIGIBLE = 1e-6
#: Fraction of the mass, or of all particle-steps, above which results may be visibly wrong.
_MATTERS = 1e-3
#: Ranks up to which run.json has the timings of each.
_MOST_RANKS = 256


def accuracy(path: Path, case: Case) -> str:
    """Return the line about a run's accuracy; empty if all is well, or nothing can be told."""
    try:
        return line(of_run(Run(path), case))
    except Exception:  # the results are complete, whatever can be said of them
        return ""


def figures(
    sim: Simulation, timings: Sequence[Mapping[str, float]] | None, total: float
) -> dict[str, object]:
    """Return what run.json has of the cost of a run; collective.

    Parameters
    ----------
    sim : Simulation
        At its end.
    timings : sequence of mapping, or None
        Seconds of each phase, rank by rank; None except on rank 0.
    total : float
        Wall time of all steps with their output.
    """
    found: dict[str, object] = {
        "particle_steps": sim.comm.allreduce(sim.rank.particle_steps),
        "total_seconds": total,
    }
    if timings is not None and len(timings) <= _MOST_RANKS:
        phases = dict.fromkeys(phase for rank in timings for phase in rank)
        found["timings"] = {
            phase: [round(rank.get(phase, 0.0), 4) for rank in timings] for phase in phases
        }
    return found


def amount(size: float) -> str:
    """Format a number of bytes with three digits."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 999.5:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.3g} TB"


def _tell(log: Log, matters: bool, what: str, wrong: str) -> None:
    """Show an event and the wrong result if it matters; else only log the event."""
    if matters:
        log.say(f"note: {what}: {wrong}")
    else:
        log.note(f"note: {what}: too little to matter")


def say_done(
    sim: Simulation, first: int, recorder: Recorder, directory: RunDirectory, log: Log, total: float
) -> None:
    """Show a summary of the steps since `first`, in `total` seconds; collective."""
    output = sum(recorder.seconds.values())
    steps = sim.step - first
    rate = sim.comm.allreduce(sim.rank.particle_steps) / max(total, 1e-9)
    since = f" since step {first}" if first else ""
    log.say(
        f"done: t = {sim.time:.6g} after {steps} steps{since} in {duration(total)}, "
        f"{rate:.3g} particle-steps/s; output took {100.0 * output / max(total, 1e-9):.0f} % "
        f"({amount(recorder.size)} at {amount(recorder.size / max(output, 1e-9))}/s)"
    )
    frames = recorder.frames.written
    collection = shlex.quote(str(directory.path / "particles.vtkhdf"))
    log.say(
        f"{frames} frame{'s' if frames > 1 else ''} and history.csv in {directory.path}; "
        f"look at them with: paraview {collection} (before 5.12: particles.xdmf)"
    )
    left = sim.count - sim.present() if sim.scene.settings.loses else 0
    if left:
        out = dict.fromkeys(name for case in sim.cases for name in exits_of(case.outflow))
        ways = [f"left through {' or '.join(out)}"] if out else []
        ways += ["were removed with their bodies"] if sim.case.staged.removed else []
        columns = [*["outflow"] * bool(out), *["removed"] * bool(sim.case.staged.removed)]
        log.say(
            f"note: {left} of {sim.count} particles {' or '.join(ways)}; the columns "
            f"{' and '.join(columns)} of history.csv tell what they took along"
        )
    clamped = sim.comm.allreduce(sim.rank.clamped)
    if clamped:
        share = clamped / (sim.count * sim.step)
        _tell(
            log,
            share > _MATTERS,
            f"in {clamped} particle-steps ({100.0 * share:.2g} %) a particle was stretched to a "
            "half-width of more than one cell, and reached no farther than one",
            "neighbours along the stretch may lose contact, and the body tear where it would not: "
            "use fewer or larger cells along the stretch",
        )
    held = sim.comm.allreduce(sim.rank.held)
    if held:
        share = held / (sim.count * sim.step)
        _tell(
            log,
            share > _MATTERS,
            f"in {held} particle-steps ({100.0 * share:.2g} %) a wall held in a particle whose "
            "centre had passed it; its velocity into the wall is lost, as a force of the wall",
            "kinetic energy is lost at the wall, and what lies there is denser than it should be: "
            "smaller cells or steps, or finite-gimp, press fewer particles through",
        )
    kinematics = sim.rank.surface_kinematics
    fallbacks = sim.comm.allreduce(kinematics.fallbacks if kinematics else 0)
    if fallbacks:
        _tell(
            log,
            True,
            f"in {fallbacks} particle-steps the positions around a loaded surface gave no usable "
            "deformation, and the load followed F of the particle alone",
            "there its area and normal may be wrong: look whether the body has torn, or take more "
            "particles, or formulation: total-lagrangian",
        )
    part, when, face = sim.diagnostic_sums.most_outside
    if part > _NEGLIGIBLE:
        _tell(
            log,
            part > _MATTERS,
            f"up to {100.0 * part:.2g} % of the mass lay past {face} (t = {when:.6g}), borne by "
            "the wall",
            f"weights and pressures of the rest are too small by that part, and forces on {face}: "
            "a size that follows the deformation (finite-gimp), or wall: mirror, avoids that",
        )
