"""What corners do that boxes along the grid do not: shear and rotation, and their cost.

Shapes that follow the deformation, two particles a cell and direction: the generalised vortex of
cases/vortex.yaml at three angles, the spin that a block loses, and the time of a step of a large
block that drifts, by turns in one process. Run as ``scripts/hard corners``: writes
the table of docs/methods.md, scripts/pages/tables/corners.md.
"""

import numpy as np
from studies.hard.courant import limits
from studies.harness import CASES, Table, put
from studies.method.bodies import large, spin
from studies.pareto.large_bodies import turned
from studies.scenes import by_id, by_turns, core, finished

from pgimp.errors import RunError

SHAPES = ("gimp", "finite-gimp", "cpdi", "cpdi-corners")
RADIUS = 1.0  # mean one of the ring, in metres


def vortex(method, cells, amplitude):
    """Errors at a quarter of the period, or None if a particle is turned inside out.

    Mean square of the displacement's error over the greatest displacement; mean |J - 1|.
    """
    cell = 0.5 / cells
    sim = core(CASES / "vortex.yaml", {
        "grid.cell": [cell, cell], "grid.size": [3.0, 3.0], "grid.origin": [-1.5, -1.5],
        "time.step": 0.08 * cell, "method.shape": method[0], "method.affine": method[1],
        "exact.generalized-vortex.amplitude": amplitude,
    })  # fmt: skip
    p = sim.particles
    start = by_id(sim, p.x[sim.live()])
    try:
        for _ in range(round(0.5 / (0.08 * cell))):
            sim.advance()
    except RunError:
        return None
    live = sim.live()
    X, x, V = start[p.id[live]], p.x[live], p.V0[live]
    off = ((x - turned(X, amplitude)) ** 2).sum(axis=1)
    error = np.sqrt(np.average(off, weights=V)) / (amplitude * RADIUS)
    J = np.linalg.det(p.F[live].reshape(-1, 2, 2))
    return float(error), float(np.average(np.abs(J - 1.0), weights=V))


def lost(method, D):
    """Part of its spin that a block has lost after a turn."""
    sim = spin(method, D)
    p = sim.particles

    def angular():
        live = sim.live()
        r = p.x[live] - np.average(p.x[live], axis=0, weights=p.m[live])
        r, v = np.pad(r, ((0, 0), (0, 3 - D))), np.pad(p.v[live], ((0, 0), (0, 3 - D)))
        axis = np.array([0.0, 0.0, 1.0] if D == 2 else [1.0, 2.0, 3.0])
        return (p.m[live, None] * np.cross(r, v)).sum(axis=0) @ axis

    first = angular()
    finished(sim)
    return 1.0 - angular() / first


def costs(methods, D, rounds=5, steps=20):
    """CPU time of a step over that of the first method, by turns: the least of rounds."""
    least = by_turns([large(method, D) for method in methods], rounds + 1, steps).min(axis=0)
    return least / least[0]


def main():
    table = Table("", *SHAPES)
    for affine in (False, True):
        methods, more = [(shape, affine, 2) for shape in SHAPES], ", affine" if affine else ""
        for amplitude in (0.15, 0.5, 1.0):
            for cells in (8, 16, 32):
                found = [vortex(method, cells, amplitude) for method in methods]
                errors = ("stopped" if one is None else f"{one[0]:.1e} ({one[1]:.1e})"
                          for one in found)  # fmt: skip
                table.add(f"vortex, angle {amplitude:g}, {cells} cells{more}", *errors)
        for D in (2, 3):
            table.add(f"spin lost in a turn, {D}D{more}", *(f"{lost(m, D):.2g}" for m in methods))
        for D in (2, 3):
            table.add(f"time of a step, {D}D{more}", *(f"{t:.2f}" for t in costs(methods, D)))
        for D in (2, 3):
            found = (limits({"shape": s, "affine": affine}, D, 2, 2000, 0.02)[0] for s in SHAPES)
            table.add(f"largest Courant number, {D}D{more}", *(f"{one:.2f}" for one in found))
    put({"corners": table.text()})
