"""A beam on a block and a plate on a ring: bodies that are carried by edges."""

from math import log

import numpy as np
from studies.patches.impacts import exact
from studies.scenes import box, core


def beam(edge=0.44, cell=0.01):
    """Deflection of a rubber beam over that of theory, and sideways over vertical force.

    Plane stress, half of it: it is carried by the edge of a rigid block, and juts out beyond.
    """
    young, thick, p, end, h = 1e7, 0.04, 25.0, 0.50, cell
    case = {
        "format": 1, "dimensions": 2, "geometry": "plane-stress",
        "grid": {"size": [0.60, 0.30], "cell": [h, h]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2], "affine": True},
        "time": {"end": 1.2, "step": {"courant": 0.5}},
        "materials": {"solid": {"model": "neo-hookean", "young": young, "poisson": 0.3,
                                "density": 1000.0}},
        "bodies": {
            "beam": exact(box([0.0, 0.10], [end, 0.10 + thick])),
            "support": {"rigid": {}, "region": box([edge, 0.02], [0.58, 0.10])},
        },
        "tractions": {"p": {"body": "beam", "face": "y-max",
                            "pressure": {"ramp": {"to": p, "duration": 0.5}}}},
        "boundaries": {"x-min": "slip"},
        "contact": [{"bodies": ["beam", "support"], "friction": 0.0}],
        "damping": {"mass": 20.0},
    }  # fmt: skip
    sim = core(case)
    while not sim.finished:
        sim.advance()
    stiff = young * thick**3 / 12.0
    span, beyond = 2.0 * edge, end - edge
    exactly = 5.0 * p * span**4 / 384.0 / stiff - p * beyond**2 * span**2 / 16.0 / stiff
    exactly += p * span**2 / 8.0 / (5.0 / 6.0 * young / 2.6 * thick)
    found = _moved(sim, [0.0, 0.5 * thick + 0.10])[1]
    line = sim.diagnostics()
    side = abs(line.get("contact.beam+support-x", 0.0))
    return -found / exactly, side / (p * end)


def _moved(sim, place):
    """Mean displacement of the particles nearest to an initial place."""
    p, rows = sim.particles, sim.live()
    away = np.round(((p.origin[rows] - place) ** 2).sum(axis=1), 12)
    near = rows[away == away.min()]
    return (p.x[near] - p.origin[near]).mean(axis=0)


def plate_theory(a, b, thick, p, young=2.1e5, nu=0.3):
    """Deflection in the middle of a circular plate carried at a radius, of all of a radius."""
    D = young * thick**3 / 12.0 / (1.0 - nu**2)
    q = p / 64.0 / D
    # w = q r^4 + A + B r^2 inside; q r^4 + C + E r^2 + F ln r + G r^2 ln r outside.

    def moment(r):  # of r^4, r^2, ln r, r^2 ln r: w'' + nu w'/r
        return (
            12.0 * r * r + nu * 4.0 * r * r, 2.0 + 2.0 * nu, (nu - 1.0) / r**2,
            2.0 * log(r) + 3.0 + nu * (2.0 * log(r) + 1.0),
        )  # fmt: skip

    at, out = moment(a), moment(b)
    rows = [
        ([1, a * a, 0, 0, 0, 0], -q * a**4),
        ([0, 0, 1, a * a, log(a), a * a * log(a)], -q * a**4),
        ([0, 2 * a, 0, -2 * a, -1 / a, -a * (2 * log(a) + 1)], 0.0),
        ([0, at[1], 0, -at[1], -at[2], -at[3]], 0.0),
        ([0, 0, 0, out[1], out[2], out[3]], -q * out[0]),
        ([0, 0, 0, 0, 0, 4.0 / b], -32.0 * q * b),
    ]
    found = np.linalg.solve([r for r, _ in rows], [v for _, v in rows])
    shear = p * a * a / 4.0 / (5.0 / 6.0 * young / 2.0 / (1.0 + nu) * thick)
    return abs(found[0]) + shear


def plate(edge=38.0, cell=1.0):
    """Deflection of a steel plate under pressure on a rigid ring over that of theory."""
    case = {
        "format": 1, "dimensions": 2, "geometry": "axisymmetric",
        "grid": {"size": [42.0, 40.0], "cell": [cell, cell]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
        "time": {"end": 1.5e-3, "step": {"courant": 0.5}},
        "materials": {"solid": {"model": "neo-hookean", "young": 2.1e5, "poisson": 0.3,
                                "density": 7.85e-9}},
        "bodies": {
            "plate": exact(box([0.0, 16.0], [40.0, 20.0])),
            "ring": {"rigid": {}, "region": box([edge, 20.0], [45.0, 26.0])},
        },
        "tractions": {"p": {"body": "plate", "face": "y-min",
                            "pressure": {"ramp": {"to": 2.0, "duration": 5.0e-4}}}},
        "contact": [{"bodies": ["plate", "ring"], "friction": 0.0}],
        "damping": {"mass": 30000.0},
    }  # fmt: skip
    sim = core(case)
    while not sim.finished:
        sim.advance()
    return _moved(sim, [0.0, 18.0])[1] / plate_theory(edge, 40.0, 4.0, 2.0)
