"""Particles at random places, and the region that a file of them is."""

import numpy as np
from meshes import case


def cloud(n=60, dimension=2):
    """Columns of particles at random places."""
    rng = np.random.default_rng(4)
    return {
        "position": rng.uniform(-1.5, 1.5, (n, dimension)),
        "volume": rng.uniform(0.01, 0.06, n),
        "velocity": rng.uniform(-0.1, 0.1, (n, dimension)),
    }


def points(path):
    """The region that the particles of a file make."""
    return {"points": {"file": str(path)}}


def affine(region, D, **parts):
    """A case with ``method.affine``."""
    found = case(region, dimension=D, **parts)
    found["method"]["affine"] = True
    return found
