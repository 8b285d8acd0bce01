"""Points around regions."""

import numpy as np


def around(found, n, seed):
    """Points in and around a region, also one without an end or without a point, (n, D)."""
    low, high = (np.clip(end, -20.0, 20.0) for end in found.bounds())
    low, high = np.minimum(low, high) - 1, np.maximum(low, high) + 1
    return np.random.default_rng(seed).uniform(low, high, (n, len(low)))
