"""A block that touches nothing, for functions of one's own."""

import pytest

import pgimp
from pgimp.errors import CaseError


def case(**parts):
    """A block in 2D that touches nothing."""
    box = {"box": {"min": [1.0, 1.0], "max": [3.0, 3.0]}}
    return {
        "format": 1, "dimensions": 2, "grid": {"size": [4.0, 4.0], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
        "time": {"end": 0.1, "step": 0.01},
        "materials": {"m": {"model": "neo-hookean", "young": 100.0, "poisson": 0.3,
                            "density": 1.0}},
        "bodies": {"b": {"material": "m", "region": box}},
    } | parts  # fmt: skip


def refused(**parts):
    with pytest.raises(CaseError) as error:
        pgimp.load(case(**parts))
    return str(error.value)
