"""Hoop stress at the bore of tubes, of a sphere and of a ring that turns, over the exact one."""

import numpy as np
from studies.scenes import ball, box, case_of, core

#: With Young's modulus 1; in the plane it is 1/(1 - NU^2), 1/0.91.
NU = 0.3
SOLID = {"model": "hooke", "young": 1.0, "poisson": NU, "density": 1.0}
PUSH = 1e-3
#: Outer over inner radius.
RATIO = 2.0


def body_of(region, surface, **more):
    """A body in the initial configuration."""
    return {"material": "m", "region": region, "formulation": "total-lagrangian",
            "surface": surface} | more  # fmt: skip


def at_rest(size, region, surface, inside, **parts):
    """A body at rest with a pressure on the part of its surface that is `inside` a region."""
    load = {"body": "b", "region": inside, "pressure": PUSH, "follower": False}
    case = case_of(
        size, 1.0, {"m": SOLID}, {"b": body_of(region, surface)}, 15.0 * max(size),
        tractions={"bore": load}, damping={"mass": 2.0 / max(size)}, **parts,
    )  # fmt: skip
    sim = core(case)
    while not sim.finished:
        sim.advance()
    return sim


def by_radius(sim, x, hoop, centre):
    """What a body's particles have: radii at the start and now, hoop stress, volume, cell."""
    p, rows = sim.particles, sim.live()
    R, r = (np.sqrt(((each - centre) ** 2).sum(axis=1)) for each in (p.origin[rows], x))
    cell = np.unique(np.floor(p.origin[rows]), axis=0, return_inverse=True)[1].reshape(-1)
    return R, r, hoop, p.V0[rows], cell


def in_plane(sim, centre):
    """Hoop stresses of a body's particles over `PUSH`."""
    p, rows = sim.particles, sim.live()
    away, s = p.x[rows] - centre, p.sigma[rows]
    r = np.sqrt((away * away).sum(axis=1))
    x, y = away.T / r
    return (s[:, 0] * y * y + s[:, 1] * x * x - 2.0 * s[:, 3] * x * y) / PUSH


def tube(a, surface):
    """A tube in the plane: what `by_radius` gives of its particles."""
    b = RATIO * a
    size, centre = [2.0 * b + 4.0] * 2, b + 2.0 + np.array([0.13, -0.09])
    region = {"difference": [ball(centre, b), ball(centre, a)]}
    sim = at_rest(size, region, surface, ball(centre, 0.5 * (a + b)))
    return by_radius(sim, sim.particles.x[sim.live()], in_plane(sim, centre), centre)


def lame(r, a):
    """Exact radial and hoop stress of a tube over its pressure, and displacement."""
    b = RATIO * a
    radial, hoop = (a * a / (b * b - a * a) * (1.0 + s * b * b / (r * r)) for s in (-1.0, 1.0))
    return radial, hoop, 0.91 * r * (hoop - NU / (1.0 - NU) * radial) * PUSH


def ring(a, surface):
    """As `tube`, of a tube of rings about the axis."""
    b = RATIO * a
    ends, bore = {"y-min": "slip", "y-max": "slip"}, box([0.0, 0.0], [0.5 * (a + b), 8.0])
    sim = at_rest([np.ceil(b) + 2.0, 8.0], box([a, 0.0], [b, 8.0]), surface, bore,
                  boundaries=ends, geometry="axisymmetric")  # fmt: skip
    p, rows = sim.particles, sim.live()
    return by_radius(sim, p.x[rows], p.sigma[rows, 2] / PUSH, [0.0, 1.0] * p.origin[rows])


def sphere(a, surface):
    """As `tube`, of a hollow sphere of rings."""
    b, y = RATIO * a, RATIO * a + 2.13
    region = {"difference": [ball([0.0, y], b), ball([0.0, y], a)]}
    sim = at_rest([b + 2.0, 2.0 * b + 4.0], region, surface, ball([0.0, y], 0.5 * (a + b)),
                  geometry="axisymmetric")  # fmt: skip
    p, rows = sim.particles, sim.live()
    return by_radius(sim, p.x[rows], p.sigma[rows, 2] / PUSH, [0.0, y])


def lame_sphere(r, a):
    """Exact radial and hoop stress of a hollow sphere over its pressure, and displacement."""
    b = RATIO * a
    part = a**3 / (b**3 - a**3)
    radial, hoop = part * (1.0 - b**3 / r**3), part * (1.0 + b**3 / (2.0 * r**3))
    return radial, hoop, r * ((1.0 - NU) * hoop - NU * radial) * PUSH


def turning(a, surface):
    """As `tube`, of a ring that turns, over density times rim speed squared; means in time.

    It begins undeformed, and so breathes: with a window that ends smoothly that leaves no trace.
    """
    b = RATIO * a
    size, centre = [2.0 * b + 4.0] * 2, b + 2.0 + np.array([0.13, -0.09])
    region, rate = {"difference": [ball(centre, b), ball(centre, a)]}, PUSH**0.5 / b
    spin = {"rotation": {"about": centre.tolist(), "rate": rate}}
    sim = core(
        case_of(size, 1.0, {"m": SOLID | {"model": "neo-hookean"}},
                {"b": body_of(region, surface, velocity=spin)}, 1e9)
    )  # fmt: skip
    sim.advance()
    steps, sums, whole = round(80.0 * b / sim.dt), 0.0, 0.0
    for n in range(steps):
        sim.advance()
        if n % 4 == 0:
            weight = 1.0 - np.cos(2.0 * np.pi * n / steps)
            away = sim.particles.x[sim.live()] - centre
            r = np.sqrt((away * away).sum(axis=1))
            sums = sums + weight * np.array([r, in_plane(sim, centre)])
            whole += weight
    R, _, _, V, cell = by_radius(sim, away, 0.0, centre)
    return R, *sums / whole, V, cell


def spun(r, a):
    """Exact radial and hoop stress of a ring that turns over rho (omega b)^2; displacement."""
    b, nu = RATIO * a, NU / (1.0 - NU)
    part, both, far = (3.0 + nu) / (8.0 * b * b), a * a + b * b, (a * b / r) ** 2
    radial = part * (both - far - r * r)
    hoop = part * (both + far - (1.0 + 3.0 * nu) / (3.0 + nu) * r * r)
    return radial, hoop, 0.91 * r * (hoop - nu * radial) * PUSH


#: What is measured: its name, the run, the exact stress, what is added to the inner radius.
PROBLEMS = (
    ("thick tube in the plane", tube, lame, 0.0),
    ("thick tube of rings", ring, lame, 0.37),
    ("hollow sphere of rings", sphere, lame_sphere, 0.0),
    ("ring that turns", turning, spun, 0.0),
)


def errors(problem, cells, surface):
    """Errors within a cell of the bore, over the exact values at it, in per cent.

    Of displacement the greatest of particles. Of hoop stress that of means of cells, each against
    the exact one at its own radius: root mean square, weighted with volumes, and the greatest.
    """
    _, run, exact, more = problem
    a = cells + more
    R, r, hoop, V, cell = run(a, surface)
    _, at_bore, moved = exact(a, a)
    off = np.abs(r - R - exact(R, a)[2])[a + 1.0 > R].max() / moved
    mass = np.bincount(cell, V)
    R, hoop = (np.bincount(cell, V * each) / mass for each in (R, hoop))
    near = a + 1.0 > R
    wrong, mass = (hoop[near] - exact(R[near], a)[1]) / at_bore, mass[near]
    mean = np.sqrt((mass * wrong * wrong).sum() / mass.sum())
    return tuple(100.0 * each for each in (off, mean, np.abs(wrong).max()))
