"""Small scenes for 100,000 steps, with an order of phases: what they keep, and their noise.

Cells and density are 1, and so is the speed of waves in solids.
"""

import numpy as np
from studies.phases.bodies import SOLID, vibration, watched
from studies.scenes import case_of, core, filled, throw

#: Steps of each scene, instants at which it is looked at, and the Courant number.
STEPS, LOOKS, COURANT = 100_000, 200, 0.3
METAL = {"m": SOLID["m"] | {"model": "von-mises", "yield-stress": 0.01, "hardening": 0.05}}
SAND = {
    "m": SOLID["m"] | {"model": "drucker-prager", "cohesion": 0.0, "friction-angle": 32.0,
                       "dilation-angle": 0.0}
}  # fmt: skip
WATER = {"m": {"model": "newtonian", "bulk": 100.0, "density": 1.0}}
SIDES = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}


def _block(method, velocity=0.0, materials=SOLID, steps=STEPS):
    """A free block of 6 x 4 cells, to be set in motion; and places from its centre."""
    low, sides = np.array([4.3, 4.2]), np.array([6.0, 4.0])
    end = COURANT * steps
    room = [14.0 + np.ceil(velocity * end), 12.0]
    body = {"material": "m", **filled(low, low + sides)}
    sim = core(case_of(room, 1.0, materials, {"b": body}, end, courant=COURANT, method=method))
    return sim, sim.particles.x[sim.live()] - low - 0.5 * sides


def _kept(sim, since=0):
    """Energy in the last tenth of the time over that at the start, or in a later tenth."""
    seen = watched(sim, vibration, LOOKS)
    if seen is None:
        return None
    part = len(seen) // 10
    first = seen[since * part : (since + 1) * part].mean() if since else seen[0]
    return seen[-part:].mean() / first


def wave(method, velocity=0.0, steps=STEPS):
    """A bar that is a wave of ten cells: part of its energy that is left."""
    low, end = 1.3, COURANT * steps
    room = np.ceil(velocity * end) + 14.0
    bar = {"m": {"model": "linear-1d", "young": 1.0, "density": 1.0}}
    body = {"b": {"material": "m", **filled([low], [low + 10.0])}}
    sim = core(case_of([room], 1.0, bar, body, end, courant=COURANT, method=method))
    at = 0.2 * np.pi * (sim.particles.x[sim.live(), 0] - low)
    slope = -0.006 * np.pi * np.sin(at)
    throw(sim, velocity + 0.03 * np.cos(at)[:, None], slope[:, None, None])
    return _kept(sim)


def bends(method, velocity=0.0, materials=SOLID, steps=STEPS):
    """A block that bends: part of its energy that is left; of metal, since it has yielded."""
    sim, x = _block(method, velocity, materials, steps)
    k, size = np.pi / 6.0, 0.05
    v, L = np.zeros(x.shape), np.zeros((len(x), 2, 2))
    v[:, 1] = size * np.cos(2.0 * k * x[:, 0])
    L[:, 1, 0] = -2.0 * k * size * np.sin(2.0 * k * x[:, 0])
    v -= np.average(v, axis=0, weights=sim.particles.m[sim.live()])  # some particles are cut
    v[:, 0] += velocity
    throw(sim, v, L)
    return _kept(sim, materials is METAL)


def turns(method, steps=STEPS):
    """A block that turns once in 600 h/c: part of its spin that is left."""
    sim, x = _block(method, 0.0, SOLID, steps)
    W = np.array([[0.0, -0.01], [0.01, 0.0]])
    throw(sim, x @ W.T, np.broadcast_to(W, (len(x), 2, 2)))
    first = sim.diagnostics()["angular-momentum-z"]
    seen = watched(sim, lambda sim: sim.diagnostics()["angular-momentum-z"], LOOKS)
    return None if seen is None else seen[-1] / first


def bounces(method, steps=STEPS):
    """A block that bounces on a floor: what is lost, over its energy of fall at the start."""
    g, fall = 1.0e-4, 0.5
    body = {"material": "m", **filled([4.0, fall], [10.0, 4.0 + fall])}
    sim = core(case_of(
        [14.0, 10.0], 1.0, SOLID, {"b": body}, COURANT * steps, courant=COURANT, method=method,
        gravity=[0.0, -g], boundaries={"y-min": "unilateral"},
    ))  # fmt: skip
    sim.diagnostics()
    seen = watched(sim, lambda sim: sim.diagnostics()["dissipated-energy"], LOOKS)
    return None if seen is None else seen[-1] / (24.0 * g * fall)


def rests(method, materials, steps=STEPS):
    """Ground or water of 8 x 4 cells at rest: its speed over that of a fall of its depth."""
    g = 1.0e-4 if materials is SAND else 1.0
    body = {"material": "m", **filled([0.0, 0.0], [8.0, 4.0])}
    speed = 1.0 if materials is SAND else 10.0
    sim = core(case_of(
        [8.0, 7.0], 1.0, materials, {"b": body}, COURANT * steps / speed, courant=COURANT,
        method=method, gravity={"table": [[0.0, [0.0, 0.0]], [60.0 / speed, [0.0, -g]]]},
        boundaries=SIDES,
    ))  # fmt: skip
    seen = watched(sim, lambda sim: sim.diagnostics()["kinetic-energy"], LOOKS)
    return None if seen is None else np.sqrt(seen[-20:].mean() / 32.0 / (g * 4.0))


SCENES = {
    "wave": wave,
    "wave at 0.05 c": lambda method, **more: wave(method, 0.05, **more),
    "bends": bends,
    "bends at 0.01 c": lambda method, **more: bends(method, 0.01, **more),
    "metal": lambda method, **more: bends(method, 0.0, METAL, **more),
    "turns": turns,
    "bounces": bounces,
    "sand": lambda method, **more: rests(method, SAND, **more),
    "water": lambda method, **more: rests(method, WATER, **more),
}
