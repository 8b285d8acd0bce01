"""Stress at surfaces where it varies: hole, bore, bent beam; and a beam that must not lock."""

import numpy as np
from studies.hard.cantilever import mean_deflection
from studies.scenes import ball, box, case_of, core

import pgimp
from pgimp.solver.lagrangian.recovered_stress import recovered_stresses

SOLID = {"model": "hooke", "young": 1.0, "poisson": 0.3, "density": 1.0}
#: Speed of its pressure waves, and the stress or the greatest strain of a case.
SPEED, SIZE = 1.16, 1e-4
#: What is added to centres, or to the height of beams, in cells.
OFFSETS = ((0.0, 0.0), (0.37, 0.21), (0.13, -0.09))
SHIFTS = (0.13, 0.3, 0.5, 0.9)


@pgimp.velocity("kirsch")
def kirsch(x, t, size, radius, cx, cy, ramp):
    """Rate of the displacement about a hole in a plate that is pulled along x."""
    X, Y = x[0] - cx, x[1] - cy
    q, r = X * X + Y * Y, (X * X + Y * Y) ** 0.5
    c, s, a, mu, k = X / r, Y / r, radius, 0.5 / 1.3, 1.8
    c2, s2 = c * c - s * s, 2.0 * s * c
    rate = size / (8.0 * mu * ramp) if t < ramp else 0.0
    far = 2.0 * a * a / r * (1.0 + (k + 1.0) * c2)
    u = (k - 1.0) * r + 2.0 * r * c2 + far - 2.0 * a**4 / (r * q) * c2
    w = -2.0 * r * s2 - 2.0 * a * a / r * (k - 1.0) * s2 - 2.0 * a**4 / (r * q) * s2
    return rate * (u * c - w * s), rate * (u * s + w * c)


@pgimp.velocity("pure-bending")
def bending(x, t, size, height, cx, cy, ramp):
    """Rate of the displacement of a beam in plane strain, whose greatest strain is `size`."""
    X, Y = x[0] - cx, x[1] - cy
    rate = 2.0 * size / height / ramp if t < ramp else 0.0
    return rate * X * Y, -0.5 * rate * (X * X + 3.0 / 7.0 * Y * Y)


def at_rest(size, region, surface, frequency, **parts):
    """A simulation of a body that has come to rest."""
    body = {
        "material": "m",
        "region": region,
        "formulation": "total-lagrangian",
        "surface": surface,
    }
    ramp = parts.pop("ramp", 0.0)
    sim = core(case_of(size, 1.0, {"m": SOLID}, {"b": body}, ramp + 22.0 / frequency,
                       damping={"mass": 1.6 * frequency}, courant=0.5, **parts))  # fmt: skip
    while not sim.finished:
        sim.advance()
    return sim


def round_hole(sim, centre, radius, exact):
    """Errors of hoop stresses: rms at particles that the hole cuts, greatest at the surface.

    Of the particles' own stress, and of what is recovered; over `SIZE`. `exact` takes points.
    """
    p, rows = sim.particles, sim.live()
    X = p.origin[rows] - centre
    cut = (p.V0[rows] < 0.2499) & (np.hypot(*X.T) < radius + 2.0)
    X = X[cut]
    truth = _hoop(exact(X), X)
    own = _hoop(p.sigma[rows][cut] / SIZE, X)
    recovered = recovered_stresses(sim.rank, p.origin[rows][cut], p.body[rows][cut]) / SIZE
    angle = np.linspace(0.0, 2.0 * np.pi, 361)[:-1]
    at = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    there = recovered_stresses(sim.rank, centre + at, np.zeros(360, int)) / SIZE
    errors = (np.sqrt(np.mean((each - truth) ** 2)) for each in (own, _hoop(recovered, X)))
    return own.max(), _hoop(there, at).max(), *errors


def _hoop(stress, X):
    """Hoop stress about the origin, of xx, yy, .., xy."""
    c, s = (X / np.hypot(*X.T)[:, None]).T
    return stress[:, 0] * s * s + stress[:, 1] * c * c - 2.0 * stress[:, -1] * c * s


def _kirsch_stress(radius):
    def stress(X):
        angle, q = np.arctan2(X[:, 1], X[:, 0]), radius**2 / (X**2).sum(axis=1)
        hoop = 0.5 * (1.0 + q) - 0.5 * (1.0 + 3.0 * q * q) * np.cos(2.0 * angle)
        return _of_hoop(hoop, X)

    return stress


def _of_hoop(hoop, X):
    """Stresses xx, yy, xy with this hoop stress alone."""
    c, s = (X / np.hypot(*X.T)[:, None]).T
    return np.stack([hoop * s * s, hoop * c * c, -hoop * c * s], axis=1)


def hole(radius, offset, surface):
    """See `round_hole`: a plate about a hole, moved as an endless one at three radii."""
    half = 3 * radius + 2
    centre = half + 1.0 + np.array(offset)
    frame = [box([0.0] * 2, [2 * half + 2] * 2), box(centre - 3 * radius, centre + 3 * radius)]
    ramp = 18.0 * radius / SPEED
    given = {"size": SIZE, "radius": float(radius), "cx": centre[0], "cy": centre[1], "ramp": ramp}
    far = {"body": "b", "region": {"difference": frame},
           "velocity": {"function": "kirsch", "parameters": given}}  # fmt: skip
    region = {"difference": [box(centre - half, centre + half), ball(centre, radius)]}
    sim = at_rest([2 * half + 2] * 2, region, surface, np.pi * SPEED / (6 * radius), ramp=ramp,
                  constraints={"far": far})  # fmt: skip
    return round_hole(sim, centre, radius, _kirsch_stress(radius))


def bore(radius, offset, surface):
    """See `round_hole`: a tube twice as wide, with a pressure inside."""
    centre = 2.0 * radius + 2.0 + np.array(offset)
    load = {"body": "b", "region": ball(centre, 1.5 * radius), "pressure": SIZE}
    region = {"difference": [ball(centre, 2.0 * radius), ball(centre, radius)]}
    sim = at_rest([4 * radius + 4] * 2, region, surface, 1.0 / (1.5 * radius),
                  tractions={"bore": load})  # fmt: skip

    def exact(X):
        return _of_hoop((1.0 + 4.0 * radius**2 / (X**2).sum(axis=1)) / 3.0, X)

    return round_hole(sim, centre, radius, exact)


def beam(height, shift, surface):
    """Stress at the top of a bent beam over the exact one: of the particles there, recovered."""
    length, low = 4 * height, 2.0 + shift
    middle = np.array([0.5 * length + 1.0, low + 0.5 * height])
    ramp = 6.0 * length / SPEED
    given = {"size": SIZE, "height": float(height), "cx": middle[0], "cy": middle[1], "ramp": ramp}
    ends = {"difference": [box([0.0] * 2, [length + 2, height + 4]),
                           box([2.0, 0.0], [length, height + 4])]}  # fmt: skip
    held = {"body": "b", "region": ends,
            "velocity": {"function": "pure-bending", "parameters": given}}  # fmt: skip
    region = box([1.0, low], [length + 1.0, low + height])
    sim = at_rest([length + 2, height + 4], region, surface, 3.0 * SPEED * height / length**2,
                  ramp=ramp, constraints={"ends": held})  # fmt: skip
    p, rows = sim.particles, sim.live()
    x, exact = p.origin[rows], SIZE / 0.91
    top = (np.abs(x[:, 0] - middle[0]) < height) & (x[:, 1] > x[:, 1].max() - 1e-6)
    at = np.stack([x[top, 0], np.full(top.sum(), low + height)], axis=1)
    found = recovered_stresses(sim.rank, at, np.zeros(len(at), int))
    return p.sigma[rows][top, 0].mean() / exact, found[:, 0].mean() / exact


def locked(cells, shift, surface):
    """Deflection of a cantilever with Poisson's ratio 0.4999 over the exact one, less 1."""
    h, pull = 1.0 / cells, -5e-4
    low = 0.5 + shift * h
    solid = {"model": "neo-hookean", "young": 1.0, "poisson": 0.4999, "density": 1.0}
    body = {"material": "m", "region": box([0.0, low], [2.0, low + 1.0]),
            "formulation": "total-lagrangian", "surface": surface}  # fmt: skip
    load = {"body": "b", "face": "x-max",
            "traction": {"table": [[0.0, [0.0, 0.0]], [56.0, [0.0, pull]]]}}  # fmt: skip
    sim = core(case_of([2.5, 2.5], h, {"m": solid}, {"b": body}, 84.0, tractions={"end": load},
                       boundaries={"x-min": "fixed"}, method={"volumetric": "b-bar"},
                       courant=0.35))  # fmt: skip
    found = []
    while not sim.finished:
        sim.advance()
        if sim.time > 56.0 and sim.step % 50 == 0:
            p, rows = sim.particles, sim.live()
            found.append(np.average(p.x[rows, 1] - p.origin[rows, 1], weights=p.m[rows]))
    return np.mean(found) / mean_deflection(1.0, 0.4999, 2.0, 1.0, pull, (32, 16)) - 1.0
