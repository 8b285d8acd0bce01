"""Level ground that starts with the stress of its weight."""

import numpy as np
from scenes import box, scene, start

SOIL = {"young": 1000.0, "poisson": 0.3, "cohesion": 0.5, "friction-angle": 30.0}


CLAY = {"m": 1.0, "lambda": 0.1, "kappa": 0.02, "void-ratio": 1.0, "shear": 400.0}


LAWS = {
    "hooke": {"young": 1000.0, "poisson": 0.3},
    "neo-hookean": {"young": 1000.0, "poisson": 0.3},
    "von-mises": {"young": 1000.0, "poisson": 0.3, "yield-stress": 10.0},
    "mohr-coulomb": SOIL,
    "cam-clay": CLAY | {"preconsolidation": 10.0},
}


K0, WIDE, HIGH = 0.6, 3, 5


def ground(law, dimension=2, k0=K0, **parts):
    """Level ground on the lines of the grid, 5 high, of density 1 under a gravity of 1."""
    size = [float(WIDE)] * (dimension - 1) + [float(HIGH)]
    sides = {
        f"{axis}-{end}": "slip" for axis in "xyz"[: dimension - 1] for end in ("min", "max")
    }  # fmt: skip
    case = scene(dimension, box([0.0] * dimension, size), cells=[WIDE] * (dimension - 1) + [7],
                 gravity=[0.0] * (dimension - 1) + [-1.0], step={"courant": 0.3}, end=1e6,
                 boundaries=sides | {f"{'xyz'[dimension - 1]}-min": "slip"},
                 start={"stress": {"k0": k0}}, **parts)  # fmt: skip
    case["materials"]["soft"] = {"model": law, "density": 1.0} | LAWS[law]
    return case


def fastest(case, steps=1000):
    """Greatest velocity of a particle in some steps, over the wave speed; and the simulation."""
    sim, most = start(case), 0.0
    speed = sim.rate * min(case["grid"]["cell"])
    for _ in range(steps):
        sim.advance()
        most = max(most, np.abs(sim.particles.v[sim.live()]).max())
    return most / speed, sim


def depth(sim, axis, top=float(HIGH)):
    return top - sim.particles.x[sim.live(), axis]
