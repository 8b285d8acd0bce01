"""Free bodies that vibrate, turn and move: what is left of their energy, with an order of phases.

Cells and density are 1, and so is the speed of longitudinal waves.
"""

import numpy as np
from studies.scenes import case_of, core, filled, throw

from pgimp.errors import RunError

#: Poisson's ratio of blocks, and Young's modulus for waves of speed 1.
POISSON = 0.3
YOUNG = (1.0 + POISSON) * (1.0 - 2.0 * POISSON) / (1.0 - POISSON)
SOLID = {"m": {"model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": 1.0}}
#: Cells of a bar, and its greatest strain.
CELLS, STRAIN = 10, 0.03
#: Sides of a block.
BLOCK = (16.0, 8.0, 8.0)


def vibration(sim):
    """Energy of all particles, as seen from the centre of mass."""
    line = sim.diagnostics()
    moving = sum(line.get(f"momentum-{axis}", 0.0) ** 2 for axis in "xyz") / (2.0 * line["mass"])
    return line["kinetic-energy"] + line["strain-energy"] - moving


def watched(sim, look, times=400):
    """What is seen at about so many instants until the end; None from where the run fails."""
    seen, every = [look(sim)], sim.clock.end / times
    try:
        while not sim.finished:
            sim.advance()
            if sim.time >= len(seen) * every:
                seen.append(look(sim))
    except RunError:
        return None
    return np.array(seen)


def wave(method, velocity=0.0, periods=100, courant=0.3):
    """A free bar that is a wave of ten cells: parts of its energy and amplitude that are left."""
    low = 1.3
    room = np.ceil(abs(velocity) * periods * CELLS) + CELLS + 4.0
    sim = core(case_of(
        [room], 1.0, {"m": {"model": "linear-1d", "young": 1.0, "density": 1.0}},
        {"b": {"material": "m", **filled([low], [low + CELLS])}}, periods * CELLS,
        courant=courant, method=method,
    ))  # fmt: skip
    p, rows, k = sim.particles, sim.live(), 2.0 * np.pi / CELLS
    at = k * (p.x[rows, 0] - low)
    shape = np.zeros(p.id.max() + 1)
    shape[p.id[rows]] = np.cos(at)
    throw(sim, velocity + STRAIN * np.cos(at)[:, None], -STRAIN * k * np.sin(at)[:, None, None])

    def look(sim):
        p, rows = sim.particles, sim.live()
        return vibration(sim), (shape[p.id[rows]] * (p.v[rows, 0] - p.v[rows, 0].mean())).mean()

    seen = watched(sim, look, 40 * periods)
    if seen is None:
        return None
    energy, motion = seen[:, 0], np.abs(seen[:, 1])
    return energy[-40:].mean() / energy[:40].mean(), motion[-40:].max() / motion[:40].max()


def block(method, D=2, turn=0.0, velocity=0.0, end=640.0, courant=0.3):
    """A block of 16 x 8 cells that bends in ten periods: parts of energy and of spin that are left.

    `turn` is its angular velocity.
    """
    room = [BLOCK[0] + 14.0 + np.ceil(velocity * end), *[BLOCK[1] + 16.0] * (D - 1)]
    low = np.array([7.37, 8.21, 8.11][:D])
    sides = np.array(BLOCK[:D])
    body = {"material": "m", **filled(low, low + sides)}
    sim = core(case_of(room, 1.0, SOLID, {"b": body}, end, courant=courant, method=method))
    x, v = sim.particles.x[sim.live()] - low - 0.5 * sides, np.zeros((sim.rank.count, D))
    L, k = np.zeros((len(x), D, D)), np.pi / BLOCK[0]
    v[:, 0] = 0.05 * np.sin(k * (x[:, 0] + 8.0)) - turn * x[:, 1]
    v[:, 1] = -0.025 * np.cos(k * (x[:, 0] + 8.0)) + turn * x[:, 0]
    L[:, 0, 0] = 0.05 * k * np.cos(k * (x[:, 0] + 8.0))
    L[:, 1, 0] = 0.025 * k * np.sin(k * (x[:, 0] + 8.0)) + turn
    L[:, 0, 1] = -turn
    v -= v.mean(axis=0)
    v[:, 0] += velocity
    throw(sim, v, L)
    seen = watched(sim, lambda sim: (vibration(sim), sim.diagnostics()["angular-momentum-z"]))
    if seen is None:
        return None
    return seen[-40:, 0].mean() / seen[0, 0], seen[-1, 1] / seen[0, 1] if turn else None


def dzhanibekov(method, end=1000.0):
    """An elastic brick that turns about its middle axis: parts of energy and spin left."""
    sides, rate = np.array([8.0, 4.0, 2.0]), np.array([0.002, 0.05, 0.0])
    low = np.array([4.3, 6.2, 7.1])
    body = {"material": "m", **filled(low, low + sides)}
    sim = core(case_of([16.0] * 3, 1.0, SOLID, {"b": body}, end, method=method))
    x = sim.particles.x[sim.live()] - low - 0.5 * sides
    W = np.cross(np.eye(3), rate)
    throw(sim, x @ W.T, np.broadcast_to(W, (len(x), 3, 3)))

    def look(sim):
        line = sim.diagnostics()
        return vibration(sim), np.sqrt(sum(line[f"angular-momentum-{a}"] ** 2 for a in "xyz"))

    seen = watched(sim, look)
    if seen is None:
        return None
    return seen[-20:, 0].mean() / seen[0, 0], seen[-1, 1] / seen[0, 1]
