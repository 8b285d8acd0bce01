"""Particles that stop the run: all ranks learn of them together, and what people are told."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.kernels.g2p import INVERTED, NOT_FINITE, OUTSIDE, TOO_FAST

if TYPE_CHECKING:
    from pgimp.solver.simulation import Simulation

#: So many particles at fault are listed on each rank; the others are only counted.
ROOM = 1024

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
    "letting particles go there (escape), an earlier time.end",
}
#: At a face with a condition, which holds particles in unless it moves them out.
_DRAWN_OUT = (
    "a larger grid (grid.origin, grid.size), and constraints on a part of the body instead of the "
    "condition on that face, which moves the material out of the domain, or lets it move out"
)


class Failure(NamedTuple):
    """The step that failed; the same on every rank.

    Attributes
    ----------
    number : int
        Particles at fault on all ranks.
    step, time, dt : int, float, float
        Number, end and length of the step.
    text : str
        What to tell people.
    """

    number: int
    step: int
    time: float
    dt: float
    text: str


def listed(sim: "Simulation", numbers: list[int]) -> np.ndarray:
    """Rows and faults, in canonical order, of a rank's particles at fault in this step.

    Parameters
    ----------
    numbers : list of int
        How many have been found by each call; the first ones are in `sim.fault_room`.

    Returns
    -------
    (n, 2) int64
        At most `ROOM`.
    """
    found = np.concatenate([room[:n] for room, n in zip(sim.fault_room, numbers, strict=False)])
    place = np.empty(sim.particles.capacity, np.int64)
    place[sim.population.order] = np.arange(len(sim.population.order))
    return found[np.argsort(place[found[:, 0]])][:ROOM]


def collect(sim: "Simulation", time: float, dt: float) -> Failure:
    """Put together what all ranks know of the step to `time` that failed; collective.

    The message is about the first particle at fault in canonical order.
    """
    first = _describe(sim, time, dt) if sim.failed else None
    found = sim.comm.allgather((sim.failed, first))
    number = sum(part[0] for part in found)
    what, where, advice = next(part[1] for part in found if part[1])
    others = number - 1
    if others:
        are = "others are" if others > 1 else "other is"
        where += f"; {others} {are} at fault in the same step"
    return Failure(number, sim.step + 1, time, dt, f"{what}\n  {where}\n  try: {advice}")


def _describe(sim: "Simulation", time: float, dt: float) -> tuple[str, str, str]:
    """What is wrong with the rank's first particle at fault, when and where, what to try."""
    p, (row, fault) = sim.particles, sim.faults[0].tolist()
    place = ", ".join(f"{x:.6g}" for x in p.x[row])
    velocity = ", ".join(f"{v:.4g}" for v in p.v[row])
    body = sim.scene.body_names[p.body[row]]
    advice = _ADVICE[fault]
    if fault == OUTSIDE and _face(sim, row) in sim.case.boundaries:
        advice = _DRAWN_OUT
    return (
        f"particle {p.id[row]} of body '{body}' {explanation(sim, row, fault)}",
        f"in step {sim.step + 1} to time {time:.6g} (dt {dt:.4g}), at ({place}), velocity "
        f"({velocity}), on rank {sim.comm.rank}",
        advice,
    )


def explanation(sim: "Simulation", row: int, fault: int) -> str:
    """What is wrong with the particle in `row`: "is turned inside out", "left the domain ..."."""
    return _WHAT[fault] + (f" through {_face(sim, row)}" if fault == OUTSIDE else "")


def _face(sim: "Simulation", row: int) -> str:
    """Name of the face, of those that let nothing go, beyond which a particle lies."""
    frame = sim.scene.frame
    for d, x in enumerate(sim.particles.x[row]):
        xi = (x - frame.origin[d]) * frame.inverse[d]
        if not 0.0 <= xi <= frame.cells[d] and not sim.scene.exits >> (2 * d + (xi > 0.0)) & 1:
            return f"{'xyz'[d]}-{'max' if xi > 0.0 else 'min'}"
    return "a face"
