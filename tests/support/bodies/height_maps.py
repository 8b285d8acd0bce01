"""Regions between a plane and a file of heights."""

import numpy as np


def hills(n=9, m=7, low=-0.6, high=1.3, seed=3):
    """Heights by x and y."""
    return np.random.default_rng(seed).uniform(low, high, (n, m))


def heights(path, **more):
    return {"heights": {"file": str(path), "bottom": -1.5, **more}}
