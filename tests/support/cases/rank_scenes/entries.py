"""What the scenes share: materials, fields and motions."""

from scenes import BAR, SOFT

STIFF = {"model": "hooke", "young": 300.0, "poisson": 0.25, "density": 2.0}

#: Two models in the scenes with gimp; those with mpm share the kernels of other tests.
PAIR = {"soft": SOFT, "stiff": STIFF}

LINE = {"soft": BAR, "stiff": {**BAR, "young": 400.0, "density": 2.0}}

EVERYTHING = ["velocity", "stress", "deformation", "displacement"]

GRID = ["mass", "momentum", "velocity", "force"]


def turning(body, about, rate, velocity):
    """The same body, turning as it flies."""
    motion = {"rotation": {"about": about, "rate": rate}, "translation": velocity}
    return body | {"velocity": motion}
