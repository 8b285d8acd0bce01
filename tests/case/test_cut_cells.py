"""Which bodies are exact to their surface, and what that changes of scenes that cut nothing."""

import numpy as np
import pytest
from pydantic import ValidationError
from scenes import box, finish, scene, start

from pgimp.case.checks.exact_surfaces import cuts, exact_surfaces
from pgimp.case.grid import Grid
from pgimp.case.schema import Case
from pgimp.geometry.regions import REGIONS

INITIAL = {"formulation": "total-lagrangian"}
ALONG = box([1.0, 2.0], [3.0, 3.5])
BALL = {"material": "soft", "region": {"ball": {"centre": [5.2, 5.1], "radius": 1.4}}}
FLOOR = {"y-min": "unilateral"}


def both(first, second):
    return {"a": first | INITIAL, "b": second | INITIAL}


@pytest.mark.parametrize(
    ("case", "expected"),
    [
        (scene(2, both(ALONG, BALL)), [True, True]),
        (scene(2, both(ALONG, BALL | {"surface": "exact"})), [True, True]),
        (scene(2, both(ALONG, BALL | {"surface": "whole-particles"})), [False, False]),
        (scene(2, both(ALONG | {"surface": "whole-particles"}, BALL)), [False, True]),
        (scene(2, {"a": ALONG, "b": BALL | INITIAL}), [False, True]),
        (scene(2, both(ALONG, BALL), shape="bspline-quadratic"), [False, False]),
        (scene(2, ALONG | INITIAL), [False]),
        (scene(2, ALONG | INITIAL, boundaries=FLOOR), [True]),
        (scene(2, ALONG | INITIAL, boundaries=FLOOR) | {"geometry": "axisymmetric"}, [True]),
    ],
)
def test_what_the_key_means(case, expected):
    assert exact_surfaces(Case.model_validate(case)) == expected


@pytest.mark.parametrize(("low", "exact"), [(1.0, False), (1.5, True)])
def test_mean_dilatation_needs_whole_cells(low, exact):
    case = scene(2, box([low, 2.0], [3.0, 4.0]) | INITIAL)
    assert exact_surfaces(Case.model_validate(case)) == [False]
    case["method"]["volumetric"] = "b-bar"
    assert exact_surfaces(Case.model_validate(case)) == [exact]


def test_all_stages_have_the_same_cells():
    """Bodies that meet from a stage on are exact from the start."""
    case = scene(2, ALONG | INITIAL)
    case["time"]["stages"] = [{"name": "later", "end": 2.0, "boundaries": FLOOR}]
    stages = Case.model_validate(case).stages
    assert [exact_surfaces(stage) for stage in stages] == [[True], [True]]


@pytest.mark.parametrize(
    ("region", "cut"),
    [
        ({"box": {"min": [0.1, 0.3], "max": [0.4, 0.55]}}, False),
        ({"box": {"min": [0.1, 0.3], "max": [0.4, 0.56]}}, True),
        ({"box": {"min": [-0.33, 0.3], "max": [0.4, 9.77]}}, False),
        ({"ball": {"centre": [0.4, 0.4], "radius": 0.2}}, True),
        ({"difference": [{"box": {"min": [0.1, 0.1], "max": [0.7, 0.7]}},
                         {"half-space": {"point": [0.3, 0.0], "normal": [1.0, 0.0]}}]}, False),
        ({"difference": [{"box": {"min": [0.1, 0.1], "max": [0.7, 0.7]}},
                         {"half-space": {"point": [0.3, 0.0], "normal": [1.0, 0.1]}}]}, True),
    ],
)  # fmt: skip
def test_what_is_cut(region, cut):
    """Boxes have sides of a twentieth, whose multiples are rounded."""
    grid = Grid(origin=(0.0, 0.0), size=(0.8, 0.8), cell=(0.1, 0.1))
    ((name, values),) = region.items()
    assert cuts(REGIONS[name].model_validate(values), grid, (2, 2)) == cut


def test_bodies_on_the_lattice_have_the_bits_of_whole_particles():
    """They have no parts either: no column, no slave."""
    found = []
    for surface in ("cut-particles", "exact", "whole-particles"):
        body = ALONG | INITIAL | {"surface": surface, "velocity": [0.3, 0.1]}
        load = {"push": {"body": "body", "face": "x-max", "pressure": 1.0}}
        sim = finish(start(scene(2, body, tractions=load, end=0.5)))
        assert sim.rank.slaves is None and sim.particles.products.shape[1] == 0
        found.append(sim.particles.x[sim.live()])
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


def test_the_older_word_is_refused_where_cells_cannot_be_exact():
    body = BALL | INITIAL | {"surface": "exact"}
    with pytest.raises(ValidationError, match="surface: cut-particles"):
        Case.model_validate(scene(2, body, shape="bspline-quadratic"))


def test_the_older_word_gives_the_bits_of_cut():
    found = []
    for surface in ("cut-particles", "exact"):
        body = BALL | INITIAL | {"surface": surface, "velocity": [0.3, 0.1]}
        sim = finish(start(scene(2, body, boundaries={"x-max": "slip"}, end=0.2)))
        assert len(sim.rank.slaves.keys) > 2
        found.append(sim.particles.x[sim.live()])
    np.testing.assert_array_equal(*found)
