"""Waves on liquids with crests of less than half a cell are said to die."""

import pytest

import pgimp
from pgimp.scene.checks.validity.low_waves import warnings

WATER = {"model": "newtonian", "bulk": 4.9e5, "density": 1000.0, "shear-viscosity": 1.0e-3}


def crests(gravity, size=(1.0, 0.5), cell=0.05, velocity=(0.0, 0.0), **changes):
    """What is said of a tank of water, a metre long."""
    case = pgimp.load({
        "format": 2, "dimensions": 2, "grid": {"size": [1.0, 0.7], "cell": [cell] * 2},
        "time": {"end": 5.0}, "materials": {"water": WATER}, "gravity": gravity,
        "bodies": {"water": {"material": "water", "velocity": list(velocity),
                             "region": {"box": {"min": [0.0, 0.0], "max": list(size)}}}},
        "boundaries": {"x-min": "slip", "x-max": "slip", "y-min": "slip"}, **changes,
    })  # fmt: skip
    return [str(text) for text in warnings(case)]


@pytest.mark.parametrize(("pull", "crest"), [(0.1, "0.1"), (0.25, "0.25"), (0.4, "0.41")])
def test_a_level_across_a_tilted_weight_is_lower_than_half_a_cell(pull, crest):
    """Slope times half the length, in cells: these swing 13, 4 and about 1 % too slowly."""
    (said,) = crests({"table": [[0.0, [0.0, -9.81]], [0.1, [pull, -9.81]]]})
    assert f"crests of about {crest} cells" in said


def test_a_slow_start_makes_a_low_wave():
    """A velocity u rises to u sqrt(h/g): 0.05 by 0.226 s."""
    (said,) = crests([0.0, -9.81], velocity=(0.05, 0.0))
    assert "crests of about 0.23 cells" in said


@pytest.mark.parametrize(
    "more",
    [
        {"gravity": [0.0, -9.81]},  # still
        {"gravity": [1.0, -9.81]},  # high enough
        {"gravity": [0.1, -9.81], "cell": 0.005},  # on fine cells
        {"gravity": [0.1, -9.81], "size": (0.5, 0.5)},  # a dam that breaks
        {"gravity": [0.1, 0.0], "boundaries": {"y-min": "fixed", "y-max": "fixed"}},
    ],
)
def test_others_are_not_mentioned(more):
    assert crests(**more) == []
