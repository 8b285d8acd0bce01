"""Scenes that several tests share, as the dictionaries that a case is made of, run on one rank.

The soft solid has Young's modulus 100 and density 1, so that its waves travel at about 11 cells of
size 1 a time unit, and motions of order 0.1 strain it by about a hundredth.
"""

import json

import numpy as np

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
BAR = {"model": "linear-1d", "young": 100.0, "density": 1.0}


def box(low, high, velocity=None, material="soft"):
    """A body that fills a box."""
    region = {"box": {"min": list(low), "max": list(high)}}
    body = {"material": material, "region": region}
    return body if velocity is None else body | {"velocity": velocity}


def scene(dimension, body, *, cells=None, cell=1.0, shape="gimp", per_cell=2, **parts):
    """A case of one soft body `body`, or of several bodies by their names.

    Parameters
    ----------
    dimension : int
        Directions D.
    body : dict
        As `box` gives it, or a dictionary of bodies.
    cells, cell : list or number
        Cells along each direction, 8 by default, and their size.
    per_cell : int or list
        Particles per cell along each direction.
    **parts
        Further keys of the case; `end` and `step` stand for those of ``time``, `volume`, `size` and
        `wall` for those of ``method``.
    """
    each = [cell] * dimension if np.isscalar(cell) else list(cell)
    count = [8] * dimension if cells is None else cells
    time = {"end": parts.pop("end", 1.0), "step": parts.pop("step", 0.01)}
    method = {
        "shape": shape,
        "particles-per-cell": [per_cell] * dimension if np.isscalar(per_cell) else per_cell,
        **{name: parts.pop(name) for name in ("volume", "size", "wall") if name in parts},
    }
    return {
        "format": 1,
        "dimensions": dimension,
        "grid": {"size": [n * h for n, h in zip(count, each, strict=True)], "cell": each},
        "method": method,
        "time": time,
        "materials": {"soft": {**(BAR if dimension == 1 else SOFT)}},
        "bodies": {"body": body} if "region" in body else body,
        **{key.replace("_", "-"): part for key, part in parts.items()},
    }


def wall(*velocity):
    """A prescribed velocity: numbers, rows of a table, or None where it is free."""
    return {"velocity": [{"table": v} if isinstance(v, list) else v for v in velocity]}


def start(case):
    """The simulation of a case, on one rank."""
    return Simulation(Case.model_validate(case), Serial())


def finish(sim):
    """Run a simulation to its end and return it."""
    while not sim.finished:
        sim.advance()
    return sim


def field(sim, name):
    """A field of all particles in ascending id, (n, ...), a copy."""
    p, rows = sim.particles, sim.live()
    return getattr(p, name)[rows[np.argsort(p.id[rows])]]


def stir(sim, amplitude):
    """Give the particles a smooth velocity on top, of another wavelength in each direction."""
    p, rows = sim.particles, sim.live()
    waves = np.array([1.0, -0.7, 0.6])[: p.x.shape[1]]
    p.v[rows] += amplitude * np.sin(p.x[rows][:, ::-1] * np.abs(waves) + 0.5) * waves


def take_over(sim, other):
    """Put the particles of another simulation of the same scene into this one."""
    for mine, others in zip(sim.particles, other.particles, strict=True):
        mine[...] = others
    sim.population.sort()


def energy(line):
    """Kinetic and strain energy of a line of the history."""
    return line["kinetic-energy"] + line["strain-energy"]


def tracked(sim, *names):
    """All steps to the end: columns of the history, (steps + 1, names)."""
    lines = [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        lines.append(sim.diagnostics())
    return np.array([[line[name] for name in names] for line in lines]).T


def write_case(path, case):
    """Write a case file; what is JSON is YAML."""
    path.write_text(json.dumps(case, indent=1))
