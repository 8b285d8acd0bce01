"""Frequencies of standing waves at a free surface and in a cylinder, against exact ones."""

import numpy as np
from studies.scenes import case_of, core, filled

from pgimp.kernels.data.motion import KEPT_MASS, KEPT_VELOCITY

COURANT, SMALL = 0.3, 1e-4
#: Young's modulus, density and Poisson's ratio, and speeds of P and S waves.
YOUNG, RATIO = 100.0, 0.3
P = float(np.sqrt(YOUNG * (1.0 - RATIO) / ((1.0 + RATIO) * (1.0 - 2.0 * RATIO))))
S = float(np.sqrt(0.5 * YOUNG / (1.0 + RATIO)))
#: Where the surface cuts its cells.
CUTS = (0.0, 0.21, 0.37, 0.5, 0.83)


def error(case, mode, exact, periods=6.0):
    """Frequency of a mode that begins with velocities `mode(*places)`, less 1 over the exact one.

    The momentum along the mode is fitted by a wave of that frequency.
    """
    sim = core(case)
    grid, frame = sim.rank.grid, sim.scene.domain.frame

    def values():
        return grid.by_vertex(grid.kept.values)[:, 0]

    there = values()[..., KEPT_MASS].copy()
    places = [
        np.arange(n) + low - frame.ghost + begin
        for n, low, begin in zip(there.shape, grid.window.lower, frame.origin, strict=False)
    ]
    shapes = mode(*np.meshgrid(*places, indexing="ij"))
    weights, seen, dt = [], [], case["time"]["step"]
    for d, shape in enumerate(shapes):
        shape = shape.reshape(there.shape) * (there > 0.0)
        values()[..., KEPT_VELOCITY + d] = SMALL * shape
        weights.append(there * shape)
    if sim.rank.slaves:
        sim.rank.slaves.spread(sim.rank, grid.kept.values, KEPT_VELOCITY)
    for _ in range(round(periods * 2.0 * np.pi / exact / dt)):
        seen.append(
            sum((w * values()[..., KEPT_VELOCITY + d]).sum() for d, w in enumerate(weights))
        )
        sim.advance()
    t, seen = np.arange(len(seen)) * dt, np.array(seen)

    def left(w):
        both = np.stack([np.cos(w * t), np.sin(w * t)], axis=1)
        return np.linalg.lstsq(both, seen, rcond=None)[1][0]

    w = exact * np.linspace(0.9, 1.05, 601)
    residuals = [left(each) for each in w]
    best = min(max(int(np.argmin(residuals)), 1), len(w) - 2)
    a, b, _ = np.polyfit(w[best - 1 : best + 2] - exact, residuals[best - 1 : best + 2], 2)
    return -b / (2.0 * a) / exact


def _case(mass, cells, low, high, ratio, **parts):
    law = {"model": "hooke", "young": YOUNG, "poisson": ratio, "density": 1.0}
    body = {"material": "solid", "formulation": "total-lagrangian"} | filled(low, high)
    speed = P if ratio else np.sqrt(YOUNG)
    parts["time"] = {"end": 1e6 * COURANT / speed, "step": COURANT / speed}
    return case_of(cells, 1.0, {"solid": law}, {"body": body}, 1.0, method={"mass": mass}, **parts)


def rayleigh_speed():
    """Of surface waves: the root of Rayleigh's equation."""
    x = np.roots([1.0, -8.0, 24.0 - 16.0 * (S / P) ** 2, 16.0 * ((S / P) ** 2 - 1.0)])
    return S * np.sqrt(next(r.real for r in x if abs(r.imag) < 1e-12 and 0.0 < r.real < 1.0))


def rayleigh(mass, cells, cut):
    """Error of the speed of a Rayleigh wave of some cells on ground three waves deep, a ring."""
    c, k, depth = rayleigh_speed(), 2.0 * np.pi / cells, 3 * cells
    top = depth + cut
    q, s = k * np.sqrt(1.0 - (c / P) ** 2), k * np.sqrt(1.0 - (c / S) ** 2)

    def mode(x, y):
        z = top - y
        along = np.exp(-q * z) - 2.0 * q * s / (s * s + k * k) * np.exp(-s * z)
        up = q / k * (np.exp(-q * z) - 2.0 * k * k / (s * s + k * k) * np.exp(-s * z))
        return along * np.sin(k * x), -up * np.cos(k * x)

    faces = {"x-min": "periodic", "x-max": "periodic", "y-min": "fixed"}
    case = _case(mass, [cells, depth + 3], [0, 0], [cells, top], RATIO, boundaries=faces)
    return error(case, mode, k * c)


def bessel(r):
    """Bessel's function J_1."""
    t = (np.arange(400) + 0.5) * np.pi / 400
    return np.cos(t - r[..., None] * np.sin(t)).mean(axis=-1)


def cylinder(mass, radius, cut):
    """Error of the second radial mode of a solid cylinder without Poisson's ratio."""
    a, root = radius + cut, 5.331442773525032  # J_1'(root) = 0

    def mode(x, y):
        return (bessel(root * x / a),)

    faces = {"x-min": "slip", "y-min": "slip", "y-max": "slip"}
    case = _case(mass, [radius + 4, 3], [0, 0], [a, 3], 0.0, boundaries=faces,
                 geometry="axisymmetric")  # fmt: skip
    return error(case, mode, root * np.sqrt(YOUNG) / a)


def rows():
    """Rows of the table: errors with lumped and with averaged mass, rms over cuts."""
    for words, function, sizes in (
        ("Rayleigh wave, {} cells long", rayleigh, (6, 10, 16)),
        ("cylinder, {} cells in its radius", cylinder, (8, 16)),
    ):
        for size in sizes:
            found = []
            for mass in ("lumped", "averaged"):
                errors = [function(mass, size, cut) for cut in CUTS]
                found.append(f"{100.0 * np.sqrt(np.mean(np.square(errors))):.2g} %")
            yield [words.format(size), *found]
