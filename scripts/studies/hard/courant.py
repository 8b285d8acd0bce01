"""Map of the largest stable Courant number: free bodies at many offsets, by bisection.

And of bodies that move over the grid, whose weights change under them.

A scene holds free bodies that start at rest, each at another offset to the grid, shaken by tiny
random velocities, so that everything is linear. A Courant number, of the code's definition dt max
((c + |v|)/L), is stable for a body if its energy is less than tenfold after the last step.
"""

import numpy as np
from studies.scenes import case_of, core, filled

from pgimp.errors import RunError
from pgimp.solver.time.clock import FixedClock

BAR = {"model": "linear-1d", "young": 1.0, "density": 1.0}
SOLID = {"model": "neo-hookean", "young": 1.0, "density": 1.0}
#: Cells along a body, cells from one to the next, bodies.
BODIES = {1: (8, 12, 16), 2: (4, 8, 9), 3: (3, 7, 6)}
#: Speeds of bodies that move, over that of waves.
SPEEDS = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0)
LARGEST = 1.0
SHAKE = 1e-7


def free_bodies(method, dimension, per_cell, count=None, poisson=0.3, room=0.0):
    """Simulation of the free bodies, all of `BODIES` unless `count` says how many.

    There is `room` to move along x, in cells.
    """
    length, pitch, most = BODIES[dimension]
    count = count or most
    across = dimension - 1
    bodies = {
        f"b{k}": {"material": "solid"} | filled(
            [2.0 + k * pitch] + [2.0] * across,
            [2.0 + k * pitch + length] + [2.0 + length] * across,
        )
        for k in range(count)
    }  # fmt: skip
    return core(case_of(
        [pitch * count + 4.0 + np.ceil(room)] + [length + 6.0] * across, 1.0,
        {"solid": BAR if dimension == 1 else SOLID | {"poisson": poisson}}, bodies, 1e6,
        per_cell=per_cell, method=method, time={"step": 0.02},
    ))  # fmt: skip


def shaken(method, dimension, per_cell, speed=0.0, room=0.0, poisson=0.3):
    """The free bodies at their offsets, shaken, and moving along x at a speed; see this module."""
    sim = free_bodies(method, dimension, per_cell, poisson=poisson, room=room)
    count = BODIES[dimension][2]
    p, rows = sim.particles, sim.live()
    random = np.random.default_rng(1)
    # From one body to the next the offset grows by an irrational part of a cell, like a golden
    # section, so that it covers the cell evenly and never hits a lattice of particles.
    golden = np.array([0.6180339887498949, 0.7548776662466927, 0.5698402909980532])[:dimension]
    offsets = np.mod(0.1234 + np.outer(np.arange(count), golden), 1.0)
    p.x[rows] += offsets[p.body[rows]]
    p.v[rows] = SHAKE * random.standard_normal(p.v[rows].shape)
    p.v[rows, 0] += speed
    sim.population.sort()
    return sim


def stable_bodies(method, dimension, per_cell, courant, steps, poisson=0.3):
    """Which bodies are stable at a Courant number, (bodies,) bool."""
    sim = shaken(method, dimension, per_cell, poisson=poisson)
    return _kept(sim, courant / sim.rate, steps)


def _kept(sim, dt, steps):
    """Which bodies keep their energy, but for a factor of ten, over some steps, (bodies,) bool."""
    sim.clock = FixedClock(dt, 1e12)
    first = energies(sim)
    try:
        for step in range(steps):
            sim.advance()
            if step % 250 == 249 and (energies(sim) > 1e8 * first).any():
                break
    except RunError:
        return np.zeros(len(first), bool)
    return energies(sim) < 10.0 * first


def energies(sim):
    """Kinetic energy, as seen from the centre of mass, and strain energy of each body."""
    line, p, rows = sim.diagnostics(), sim.particles, sim.live()
    found = []
    for number, name in enumerate(sim.scene.body_names):
        mine = rows[p.body[rows] == number]
        m, v = p.m[mine, None], p.v[mine]
        v = v - (m * v).sum(axis=0) / m.sum()
        found.append(0.5 * float((m * v * v).sum()) + line[f"body.{name}.strain-energy"])
    return np.array(found)


def moving_limit(method, dimension, per_cell, speed, tolerance=0.01, steps=3000):
    """Largest stable dt c/L of bodies that move at a speed, which is over that of waves.

    A particle must not cross a cell in a step, so dt |v|/L is less than 1.
    """
    most = min(LARGEST, 0.98 / speed if speed else LARGEST)
    wave = shaken(method, dimension, per_cell).rate

    def stable(part):
        dt = part * most / wave
        sim = shaken(method, dimension, per_cell, speed * wave, 1.1 * steps * dt * speed * wave)
        return _kept(sim, dt, steps).all()

    return most * _bisect(stable, tolerance)


def limits(method, dimension, per_cell, steps, tolerance=0.01, poisson=0.3):
    """Largest stable Courant numbers: of all bodies together, and of the most stable body."""
    return tuple(
        _bisect(
            lambda courant, together=together: together(
                stable_bodies(method, dimension, per_cell, courant, steps, poisson)
            ),
            tolerance,
        )
        for together in (np.all, np.any)
    )


def _bisect(stable, tolerance):
    low, high = 0.0, LARGEST
    if stable(high):
        return high
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low
