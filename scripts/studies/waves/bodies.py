"""Frequencies of free bodies cut anywhere by the grid, from the kernels of a step."""

import numpy as np
from studies.scenes import ball, box, case_of, core

from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_MASS, KEPT_VELOCITY

COURANT, MODES, SHIFT = 0.3, 12, np.array([3.37, 3.21])
SPEED = float(np.sqrt(100.0 * 0.7 / (1.3 * 0.4)))


def _region(name, size):
    if name == "disk":
        return ball(SHIFT + 0.5 * size, 0.5 * size), (size, size)
    sides = (size, size) if name == "square" else (size, size / 4.0)
    return box(SHIFT, SHIFT + sides), sides


def operator(name, size, mass):
    """M^-1 K of a body of so many cells, and the vertices' lumped masses.

    A column is the change of all velocities in a step that begins with one displacement.
    """
    region, sides = _region(name, size)
    law = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
    body = {"material": "soft", "configuration": "initial", "region": region}
    cells = [int(np.ceil(s)) + 8 for s in sides]
    dt = COURANT / SPEED
    case = case_of(cells, 1.0, {"soft": law}, {"body": body}, 1.0, method={"mass": mass})
    case["time"] = {"end": 1e6 * dt, "step": dt}
    sim, small = core(case), 1e-7
    grid = sim.rank.grid
    values = grid.by_vertex(grid.kept.values)[:, 0, :, 0]
    there = np.argwhere(values[..., KEPT_MASS] > 0.0)
    i, j = there.T
    columns = []
    for d in (0, 1):
        for a, b in there:
            values[..., DISPLACEMENT : DISPLACEMENT + 3] = 0.0
            values[..., KEPT_VELOCITY : KEPT_VELOCITY + 3] = 0.0
            values[a, b, DISPLACEMENT + d] = small
            sim.advance()
            v = values[i, j, KEPT_VELOCITY : KEPT_VELOCITY + 2]
            columns.append(-v.T.reshape(-1) / (dt * small))
    return np.array(columns).T, np.tile(values[i, j, KEPT_MASS], 2)


def frequencies(name, size, mass, courant=COURANT):
    """The first frequencies, as steps of a Courant number give them, by the body's; the highest."""
    A, m = operator(name, size, mass)
    if mass == "lumped":
        root = np.sqrt(m)
        S = root[:, None] * A / root
        squares = np.linalg.eigvalsh(0.5 * (S + S.T))
    else:
        squares = np.sort(np.linalg.eigvals(A).real)
    w, dt = np.sqrt(np.abs(squares)), courant / SPEED
    if courant:
        w = 2.0 / dt * np.arcsin(np.minimum(1.0, dt * w / 2.0))
    return w[3 : 3 + MODES] * size, float(np.sqrt(squares[-1]))


def rows():
    """Rows of the table. References are of lumped mass on 32 and 48 cells, extrapolated."""
    for name in ("square", "disk", "strip"):
        coarse, fine = (frequencies(name, n, "lumped", 0.0)[0] for n in (32, 48))
        exact = fine + (fine - coarse) / ((48 / 32) ** 2 - 1.0)
        found = {mass: frequencies(name, 16, mass) for mass in ("lumped", "averaged")}
        errors = [np.sqrt(np.mean((w / exact - 1.0) ** 2)) for w, _ in found.values()]
        yield [f"{name}, 16 cells", *(f"{100.0 * each:.2f}" for each in errors),
               f"{found['averaged'][1] / found['lumped'][1]:.3f}"]  # fmt: skip
