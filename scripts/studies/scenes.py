"""What scenes of studies are made of, and how they are run in this process."""

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from time import process_time
from typing import Any
from unittest.mock import patch

import numpy as np

import pgimp
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation
from pgimp.solver.state.vertex_motion import begin_motion


def box(low: Iterable[float], high: Iterable[float]) -> dict[str, Any]:
    """A region along the grid."""
    return {"box": {"min": [*map(float, low)], "max": [*map(float, high)]}}


def filled(low: Iterable[float], high: Iterable[float]) -> dict[str, Any]:
    """Entry of a body, or of a constraint, with a region along the grid."""
    return {"region": box(low, high)}


def ball(centre: Iterable[float], radius: float) -> dict[str, Any]:
    """A region: a disk in 2D."""
    return {"ball": {"centre": [*map(float, centre)], "radius": float(radius)}}


def case_of(size, cell, materials, bodies, end, *, courant=0.3, per_cell=2, **parts):
    """A case with boxes (gimp) on cubic cells, `per_cell` particles a cell and direction.

    `size` is the extent of the domain, `end` that of the time. `parts` are other keys of the case;
    those of `grid`, `method` and `time` are added to what is here.
    """
    D = len(size)
    case = {
        "format": 1, "dimensions": D,
        "grid": {"size": [*map(float, size)], "cell": [float(cell)] * D},
        "method": {"shape": "gimp", "particles-per-cell": [per_cell] * D},
        "time": {"end": float(end), "step": {"courant": courant}}, "materials": materials,
        "bodies": bodies,
    }  # fmt: skip
    for name in ("grid", "method", "time"):
        case[name] |= parts.pop(name, {})
    return case | parts


def throw(sim: Simulation, v: np.ndarray, L: np.ndarray) -> None:
    """Set velocities (n, D) and their gradients (n, D, D) of particles before the first step."""
    p, rows, D = sim.particles, sim.live(), sim.scene.dimension
    p.v[rows] = v
    if p.L.shape[1]:
        p.L[rows, : D * D] = L.reshape(len(rows), -1)
    gradients = np.zeros((p.capacity, D, D))
    gradients[rows] = L
    begin_motion(sim.rank, gradients)


def core(case: Any, overrides: Any = ()) -> Simulation:
    """The solver of a case, on one rank.

    If a body has `surface: boxes`, which case files do not know, none has exact cut cells.
    """
    bodies = case["bodies"].values() if isinstance(case, dict) else ()
    boxes = [body for body in bodies if body.get("surface") == "boxes"]
    for body in boxes:
        body["surface"] = "cut-particles"
    with ExitStack() as stack:
        if boxes:
            name = "pgimp.case.checks.exact_surfaces.may_be_exact"
            stack.enter_context(patch(name, lambda bodies, _: [False] * len(bodies)))
        return Simulation(pgimp.load(case, overrides), Serial())


def finished(sim: Simulation, each: Callable | None = None) -> Simulation:
    """A solver at its end; `each` is called after every step."""
    while not sim.finished:
        sim.advance()
        if each:
            each(sim)
    return sim


def by_id(sim: Simulation, values: np.ndarray) -> np.ndarray:
    """Values of the particles there are, as `sim.live` has them, in ascending id."""
    found = np.empty_like(values)
    found[sim.particles.id[sim.live()]] = values
    return found


def a_line(sim: pgimp.Simulation) -> dict[str, float]:
    return sim.diagnostics() or {}


def reading(name: str) -> Callable:
    return lambda sim: a_line(sim)[name]


def looked(case: Any, times: Iterable[float], look: Callable, overrides: Any = ()) -> tuple:
    """What is seen of a simulation at some times; its particle-steps per CPU second; itself."""
    sim = case if hasattr(case, "particles") else pgimp.Simulation(case, overrides=overrides)
    began, count, seen = process_time(), len(sim.particles["id"]), []
    for time in times:
        sim.advance(time)
        seen.append(look(sim))
    return seen, count * sim.steps / (process_time() - began), sim


def history(sim: pgimp.Simulation) -> list[dict[str, float]]:
    """Lines of the history after each step, to the end."""
    lines = []
    while not sim.finished:
        sim.step()
        lines.append(a_line(sim))
    return lines


def by_turns(sims: Iterable, rounds: int, steps: int, clock: Callable = process_time) -> np.ndarray:
    """Seconds of a step, (rounds, simulations), by turns, as other work comes and goes."""
    sims = list(sims)
    spent = np.empty((rounds, len(sims)))
    for seconds in spent:
        for k, sim in enumerate(sims):
            began = clock()
            if isinstance(sim, Simulation):
                for _ in range(steps):
                    sim.advance()
            else:
                sim.step(steps)
            seconds[k] = (clock() - began) / steps
    return spent
