"""What to tell people when a particle stops the run."""

from typing import TYPE_CHECKING

from pgimp.kernels.g2p import INVERTED, NOT_FINITE, OUTSIDE, TOO_FAST

if TYPE_CHECKING:
    from pgimp.solver.simulation import Simulation

_WHAT = {
    NOT_FINITE: "has a position, velocity or deformation that is not a finite number",
    INVERTED: "is turned inside out (det F <= 0)",
    TOO_FAST: "moved by more than a cell in one step",
    OUTSIDE: "left the domain",
}
_UNSTABLE = (
    "smaller steps (time.step), a stiffer material or slower loading, finer cells around it"
)
_ADVICE = {
    NOT_FINITE: _UNSTABLE,
    INVERTED: f"{_UNSTABLE}, shape: gimp instead of mpm",
    TOO_FAST: _UNSTABLE,
    OUTSIDE: "a larger grid (grid.origin, grid.size), a condition on that face (boundaries), "
    "an earlier time.end",
}


def describe(sim: "Simulation", fault: int, row: int, time: float, dt: float) -> str:
    """Message about the particle in `row`: what, which, when, where, and what to try."""
    p = sim.particles
    place = ", ".join(f"{x:.6g}" for x in p.x[row])
    velocity = ", ".join(f"{v:.4g}" for v in p.v[row])
    face = f" through {_face(sim, row)}" if fault == OUTSIDE else ""
    return (
        f"particle {p.id[row]} of body '{sim.scene.body_names[p.body[row]]}' {_WHAT[fault]}{face}\n"
        f"  in step {sim.step + 1} to time {time:.6g} (dt {dt:.4g}), at ({place}), velocity "
        f"({velocity}), on rank {sim.comm.rank}\n"
        f"  try: {_ADVICE[fault]}"
    )


def _face(sim: "Simulation", row: int) -> str:
    """Name of the face beyond which the particle lies."""
    frame = sim.scene.frame
    for d, x in enumerate(sim.particles.x[row]):
        xi = (x - frame.origin[d]) * frame.inverse[d]
        if xi < 0.0:
            return f"{'xyz'[d]}-min"
        if xi > frame.cells[d]:
            return f"{'xyz'[d]}-max"
    return "a face"
