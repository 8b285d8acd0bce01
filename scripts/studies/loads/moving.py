"""A load that crosses a beam, against the exact motion of Timoshenko's beam on two supports.

Poisson's ratio is zero, so that plane strain is that of a beam, with the shear coefficient 5/6. In
the domain's faces at both ends the beam does not move across, and is free along.
"""

from time import perf_counter

import numpy as np
from studies.scenes import box, case_of, core

YOUNG, DENSITY, SPAN, HEIGHT = 1.0, 1.0, 20.0, 1.0
#: The load: its length, its pressure over Young's modulus, and its speed over the critical one.
WIDTH, PRESSURE, SPEED = 2.0, 1e-6, 0.5
#: Terms of the series; by then they are below 1e-6 of the sum.
TERMS = 60


def critical():
    """Speed at which a force crosses the beam in half of its longest period, of slender beams."""
    return np.pi / SPAN * np.sqrt(YOUNG * HEIGHT**2 / (12.0 * DENSITY))


def _mode(n, times, velocity):
    """Deflection of mode n over time: two equations, deflection and turn, integrated exactly.

    The force is the integral of the load times the mode. Between two instants it is taken as
    linear, in steps that are much shorter than the shortest period of the mode.
    """
    k, G = n * np.pi / SPAN, YOUNG / 2.0
    shear, area, inertia = 5.0 / 6.0 * G * HEIGHT, HEIGHT, HEIGHT**3 / 12.0
    A = np.array([[shear * k * k, -shear * k], [-shear * k, YOUNG * inertia * k * k + shear]])
    M = np.array([DENSITY * area, DENSITY * inertia])
    root = np.sqrt(M)
    squares, shapes = np.linalg.eigh(A / np.outer(root, root))
    middle = velocity * times - 0.5 * WIDTH
    ends = [np.clip(middle + side * 0.5 * WIDTH, 0.0, SPAN) for side in (-1.0, 1.0)]
    force = 2.0 / SPAN * PRESSURE * YOUNG * (np.cos(k * ends[0]) - np.cos(k * ends[1])) / k
    found = np.zeros(len(times))
    for square, shape in zip(squares, shapes.T, strict=True):
        part = shape[0] / root[0]
        found += part * _oscillator(np.sqrt(square), part * force, times)
    return found


def _oscillator(rate, force, times):
    """Motion q'' + rate^2 q = force from rest, by Duhamel's integral with the force linear."""
    dt = times[1] - times[0]
    s, c = np.sin(rate * dt), np.cos(rate * dt)
    q, v, found = 0.0, 0.0, np.zeros(len(times))
    for i in range(1, len(times)):
        a, slope = force[i - 1] / rate**2, (force[i] - force[i - 1]) / (dt * rate**2)
        e, d = q - a, (v - slope) / rate
        q = e * c + d * s + a + slope * dt
        v = rate * (d * c - e * s) + slope
        found[i] = q
    return found


def exact(end, velocity, steps=4000):
    """Instants, and the deflection of the middle then."""
    times = np.linspace(0.0, end, steps + 1)
    modes = range(1, TERMS, 2)  # the others are zero in the middle
    return times, sum(np.sin(0.5 * n * np.pi) * _mode(n, times, velocity) for n in modes)


def crossed(across):
    """Deflection of the middle as the load crosses, over the exact one's greatest.

    Parameters
    ----------
    across : int
        Cells of the height.

    Returns
    -------
    (float, float, float, float, int, float)
        Root mean square and greatest error over the greatest deflection, error of the greatest
        deflection, work that is not in energies over the greatest energy, steps, time in s.
    """
    h, velocity = HEIGHT / across, SPEED * critical()
    way = SPAN + WIDTH
    held = {"velocity": [None, 0.0]}
    solid = {"model": "hooke", "young": YOUNG, "poisson": 0.0, "density": DENSITY}
    start = -0.5 * WIDTH
    case = case_of(
        [SPAN, HEIGHT + 2.0 * h], h, {"m": solid},
        {"beam": {"material": "m", "region": box([0.0, h], [SPAN, HEIGHT + h]),
                  "formulation": "total-lagrangian"}},
        way / velocity, boundaries={"x-min": held, "x-max": held},
        tractions={"train": {
            "body": "beam", "pressure": PRESSURE * YOUNG, "follower": False,
            "region": box([-1.0, HEIGHT + 0.5 * h], [SPAN + 1.0, HEIGHT + 2.0 * h]),
            "profile": {"along": [1.0, 0.0], "from": [start, 0.0], "velocity": velocity,
                        "table": [[-0.5 * WIDTH, 1.0], [0.5 * WIDTH, 1.0]]},
        }},
    )  # fmt: skip
    sim = core(case)
    p, rows = sim.particles, sim.live()
    X = p.x[rows] - [0.5 * SPAN, h + 0.5 * HEIGHT]
    near = rows[np.hypot(*(X / h).T) < 0.5]
    began, times, down, energies = p.x[near, 1].mean(), [], [], []
    clock = perf_counter()
    while not sim.finished:
        sim.advance()
        times.append(sim.time)
        down.append(began - p.x[near, 1].mean())
        if sim.step % 100 == 0 or sim.finished:
            line = sim.diagnostics()
            energies.append([line[f"{name}-energy"] for name in ("kinetic", "strain")]
                            + [line["external-work"]])  # fmt: skip
    took = perf_counter() - clock
    at, right = exact(way / velocity, velocity)
    right = np.interp(times, at, right)
    off, most = np.array(down) - right, np.abs(right).max()
    stored = np.array(energies)
    lost = np.abs(stored[:, 0] + stored[:, 1] - stored[:, 2]).max() / stored[:, 2].max()
    return (np.sqrt((off**2).mean()) / most, np.abs(off).max() / most,
            np.max(down) / right.max() - 1.0, lost, sim.step, took)  # fmt: skip
