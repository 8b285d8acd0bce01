"""A quarter of a tube under pressure in its bore, at rest, against exact displacements."""

from time import perf_counter

import numpy as np
from studies.scenes import box, case_of, core

YOUNG, POISSON, INNER, OUTER = 1000.0, 0.3, 1.0, 2.0
MU = 0.5 * YOUNG / (1.0 + POISSON)
LAM = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))


def lame(pressure):
    """Displacement over the radius, by Lamé; the pressure over Young's modulus."""
    R = np.linspace(INNER, OUTER, 200)
    part = (1.0 + POISSON) * pressure * INNER**2 / (OUTER**2 - INNER**2)
    return R, part * ((1.0 - 2.0 * POISSON) * R + OUTER**2 / R)


def _radial(stress, around, guess):
    """Radial stretch of a neo-Hookean solid at a radial Piola stress, by Newton's method."""
    g = guess
    for _ in range(30):
        rest = MU * (g - 1.0 / g) + LAM * np.log(g * around) / g - stress
        g -= rest / (MU * (1.0 + g**-2) + LAM * (1.0 - np.log(g * around)) * g**-2)
    return g


def _outwards(bore, pressure, steps=2000):
    """Piola stress at the outside, and the path (R, r), of a tube whose bore has a radius."""
    around, R, r, h = bore / INNER, INNER, bore, (OUTER - INNER) / steps
    stress, g, path = -pressure * YOUNG * around, 1.0, [(R, r)]
    for _ in range(steps):
        for part in (0.5, 1.0):  # the midpoint rule
            if part == 0.5:
                first = R, r, stress
            t = r / R
            g = _radial(stress, t, g)
            other = MU * (t - 1.0 / t) + LAM * np.log(g * t) / t
            slope = (other - stress) / R
            R, r, stress = (a + part * h * b for a, b in
                            zip(first, (1.0, g, slope), strict=True))  # fmt: skip
        path.append((R, r))
    return stress, np.array(path).T


def shot(pressure):
    """Displacement over the radius of a neo-Hookean tube, by shooting."""
    low, high = INNER, 3.0 * INNER
    for _ in range(40):
        middle = 0.5 * (low + high)
        stress, path = _outwards(middle, pressure)
        low, high = (middle, high) if stress < 0.0 else (low, middle)
    return path[0], path[1] - path[0]


def blown(cells, configuration, pressure, exact, per_cell=2):
    """Errors at the bore and everywhere, the load's, steps and time; cells of the inner radius.

    The load's error is the sum of the current area vectors, as the load has them, against the bore
    where the particles are.
    """
    h, size = 1.0 / cells, [3.5, 3.5]
    whole = {"intersection": [{"ball": {"center": [0.0, 0.0], "radius": OUTER}},
                              box([0.0, 0.0], size)]}  # fmt: skip
    region = {"difference": [whole, {"ball": {"center": [0.0, 0.0], "radius": INNER}}]}
    rubber = {"model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": 1.0}
    case = case_of(
        size, h, {"m": rubber},
        {"tube": {"material": "m", "region": region, "formulation": configuration}}, 1.0,
        boundaries={"x-min": "slip", "y-min": "slip"},
        start={"equilibrate": {"tolerance": 1e-3, "steps": 20000}},
        tractions={"bore": {
            "body": "tube", "region": {"ball": {"center": [0.0, 0.0], "radius": 1.5}},
            "pressure": pressure * YOUNG,
        }}, per_cell=per_cell,
    )  # fmt: skip
    sim = core(case)
    X, began = _positions(sim), perf_counter()
    while sim.settling:
        sim.advance()
    took, R, moved = perf_counter() - began, np.hypot(*X.T), _positions(sim)
    u, right = np.hypot(*moved.T) - R, np.interp(R, *exact)
    inside, near = R > INNER, (R > INNER) & (R < INNER + h)
    bore = u[near].mean() / right[near].mean() - 1.0
    everywhere = np.sqrt(((u - right)[inside] ** 2).mean() / (right[inside] ** 2).mean())
    load = _across(sim) / (INNER + u[near].mean() / right[near].mean() * exact[1][0]) - 1.0
    return (
        f"{100 * bore:+.2f} %", f"{100 * everywhere:.2f} %", f"{100 * load:+.1f} %", sim.step,
        f"{took:.1f} s",
    )  # fmt: skip


def _across(sim):
    """Sum along x of the current area vectors of the loaded surface, J F^-T N."""
    p, rows = sim.particles, sim.live()
    F, N = p.F[rows].reshape(-1, 2, 2), p.surface[rows, 1:3]
    if p.surface_F_correction.shape[1]:
        F = p.surface_F_correction[rows].reshape(-1, 2, 2) @ F
    return float(-(F[:, 1, 1] * N[:, 0] - F[:, 1, 0] * N[:, 1]).sum())


def _positions(sim):
    """Positions by number."""
    rows = sim.live()
    return sim.particles.x[rows[np.argsort(sim.particles.id[rows])]]
