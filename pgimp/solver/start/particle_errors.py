"""Errors of particles, which stop the run: collected from all ranks, and put into messages."""

from typing import NamedTuple

import numpy as np

from pgimp.kernels.data.frame import volume_ratio
from pgimp.kernels.step.checks import INVERTED, NOT_FINITE, OUT_OF_RANGE, OUTSIDE, TOO_FAST
from pgimp.scene.checks.own_functions import force_without_value
from pgimp.solver.contact.penetration import particles_inside
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step

_WHAT = {
    NOT_FINITE: "has a position, velocity or deformation that is not a finite number",
    INVERTED: "is turned inside out (det F <= 0)",
    TOO_FAST: "moved by more than a cell in one step",
    OUTSIDE: "left the domain",
}
_UNSTABLE = "smaller steps (time.step), a stiffer material or slower loading, finer cells around it"
_ADVICE = {
    NOT_FINITE: _UNSTABLE,
    INVERTED: f"{_UNSTABLE}, shape: gimp instead of mpm",
    TOO_FAST: _UNSTABLE,
    OUTSIDE: "a larger grid (grid.origin, grid.size), a condition on that face (boundaries), "
    "letting particles go there (outflow), an earlier time.end",
}
#: At a face with a condition, which holds particles in unless it moves them out.
_DRAWN_OUT = (
    "a larger grid (grid.origin, grid.size), and constraints on a part of the body instead of the "
    "condition on that face, which moves the material out of the domain, or lets it move out"
)
#: In the initial configuration.
_MET = (
    "formulation: updated-lagrangian, in which bodies meet walls as they come (one in the initial "
    "configuration is held by a face if it lies on it at the start, and knows of no other); or no "
    "condition on that face (boundaries), if the body is to pass it"
)


class Failure(NamedTuple):
    """The step that failed; equal on every rank."""

    number: int  #: Particles at fault on all ranks.
    #: step, time, dt: int, float, float: Number, end and length of the step.
    step: int
    time: float
    dt: float
    text: str  #: The message to the user.


def collect_errors(rank: RankState, step: Step) -> Failure:
    """Collect from all ranks the reason of a failed step; collective.

    The message is about the first particle at fault in canonical order.
    """
    first = _describe(rank, step) if rank.failed else None
    found = rank.comm.allgather((rank.failed, first))
    number = sum(part[0] for part in found)
    what, where, advice = next(part[1] for part in found if part[1])
    others = number - 1
    if others:
        are = "others are" if others > 1 else "other is"
        where += f"; {others} {are} at fault in the same step"
    text = f"{what}\n  {where}\n  try: {advice}"
    return Failure(number, step.number, step.end, step.dt, text)


def _describe(rank: RankState, step: Step) -> tuple[str, str, str]:
    """Describe the rank's first particle at fault: error, position and time, advice."""
    p, (row, error) = rank.up_to_date(), rank.errors[0].tolist()
    position = ", ".join(f"{x:.6g}" for x in p.x[row])
    velocity = ", ".join(f"{v:.4g}" for v in p.v[row])
    body = rank.scene.body_names[p.body[row]]
    advice = _out_of_range(rank, row)[1] if error == OUT_OF_RANGE else _ADVICE[error]
    if error == OUTSIDE and rank.scene.settings.lagrangian[p.body[row]]:
        advice = _MET
    elif error == OUTSIDE and _face(rank, row) in rank.scene.case.boundaries:
        advice = _DRAWN_OUT
    came = origin(rank, row, step.end) if error == OUTSIDE else ""
    if error == NOT_FINITE and (text := force_without_value(rank.scene, p.x[row], step.start)):
        came, advice = f": {text}", "another force there, or another end of the run"
    return (
        f"particle {p.id[row]} of body '{body}' {explanation(rank, row, error)}{came}",
        f"in step {step.number} to time {step.end:.6g} (dt {step.dt:.4g}), at ({position}), "
        f"velocity ({velocity}), on rank {rank.comm.rank}",
        advice,
    )


def explanation(rank: RankState, row: int, error: int) -> str:
    """Explain the error of the particle in `row`: "is turned inside out", "left the domain ..."."""
    if error == OUT_OF_RANGE:
        return _out_of_range(rank, row)[0]
    return _WHAT[error] + (f" through {_face(rank, row)}" if error == OUTSIDE else "")


def origin(rank: RankState, row: int, time: float) -> str:
    """Name the rigid body from which a particle left the domain; nothing for none."""
    inside = particles_inside(rank, np.array([row], np.int32), time, 0.0)
    names = [
        name for name, n in zip(rank.scene.interaction.rigid_bodies.names, inside, strict=True) if n
    ]
    return f", from inside the rigid body '{names[0]}'" if names else ""


def _out_of_range(rank: RankState, row: int) -> tuple[str, str]:
    """Explanation and advice of a particle's material; see `Material.out_of_range`."""
    scene, p = rank.scene, rank.up_to_date()
    number = scene.materials.body_material[p.body[row]]
    entry = scene.materials.variations.entry(number, p.own[row])
    J = float(volume_ratio(p.F[row], scene.dimension))
    what, advice = entry.out_of_range(J, tuple(p.state[row].tolist()))
    return f"{what} (material '{scene.materials.names[number]}', {entry.model})", advice


def _face(rank: RankState, row: int) -> str:
    """Name of the closed face that a particle has passed."""
    frame = rank.scene.domain.frame
    if rank.scene.settings.lagrangian[rank.up_to_date().body[row]]:
        for d, (low, high) in enumerate(rank.scene.domain.bounds or ()):
            if not low <= rank.up_to_date().x[row, d] <= high:
                return f"{'xyz'[d]}-{'max' if rank.up_to_date().x[row, d] > high else 'min'}"
    for d, x in enumerate(rank.up_to_date().x[row]):
        xi = (x - frame.origin[d]) * frame.inverse[d]
        if (
            not 0.0 <= xi <= frame.cells[d]
            and not rank.scene.domain.exits >> (2 * d + (xi > 0.0)) & 1
        ):
            return f"{'xyz'[d]}-{'max' if xi > 0.0 else 'min'}"
    return "a face"
