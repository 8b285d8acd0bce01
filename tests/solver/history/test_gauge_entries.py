"""Gauges that cannot be, or not in every respect."""

import pytest
from region_entries import half_space as half
from scenes import box, finish, scene, start

import pgimp

WALLS = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}


def lying(low, high):
    """A box, whatever lies in it."""
    return {"box": {"min": low, "max": high}}


@pytest.mark.parametrize(
    ("gauges", "where", "text"),
    [
        ({"a": {"cut": {"ball": {"centre": [2, 2], "radius": 1}}}}, "a.cut", "expected a half"),
        ({"a": {"cut": half([9.0, 0.0], [-1.0, 0.0])}}, "a.cut", "lies beyond the domain along x"),
        ({"a": {"cut": half([9.0, 0.0], [1.0, 0.0])}}, "a.cut", "lies beyond the domain along x"),
        (
            {"a": {"flux": half([9.0, 9.0], [1.0, 1.0])}},
            "a.flux",
            "lies beyond the domain: nothing",
        ),
        (
            {"a": {"cut": {"box": {"min": [-1.0, 0.0], "max": [9.0, 9.0]}}}},
            "a.cut",
            "holds the whole domain, so that it has no surface",
        ),
        ({"a": {"flux": half([1.0], [1.0])}}, "a.flux", "expected 2 entries"),
        (
            {"a": {"cut": half([1.0, 1.0], [1.0, 0.0]), "about": [1.0]}},
            "a.about",
            "expected 2 entries",
        ),
        ({"a": {"wall": "y-max"}}, "a.wall", "y-max is open, and bears nothing"),
        ({"a": {"wall": "top"}}, "a.wall", "unknown face 'top'"),
        ({"a": {"level": [1.0, 1.0]}}, "a.level", "expected 1 entry"),
        ({"a": {"level": [9.0]}}, "a.level.0", "outside of the domain"),
        ({"a": {"level": [1.0], "bodies": ["bodi"]}}, "a.bodies.0", "did you mean 'body'"),
        ({"a": {"level": [1.0], "mean": 0}}, "a.mean", "must be above 0"),
        ({"a": {"weight": 1}}, "a", "known: cut, flux, level, wall"),
        ({"a": {"level": [1.0], "bodies": []}}, "a.bodies", "names no body, so that nothing is"),
        (
            {"a": {"wall": "y-min", "within": lying([0.0, 3.0], [2.0, 4.0])}},
            "a.within",
            "ends 3 cells from y-min, so that nothing in it presses there; let it reach",
        ),
        (
            {"a": {"wall": "x-max", "within": lying([7.0, 9.0], [8.0, 9.5])}},
            "a.within",
            "lies beyond the domain, whose y goes from 0 to 8: nothing is measured",
        ),
        (
            {"a": {"flux": half([1.0, 0.0], [1.0, 0.0]), "within": lying([9.0, 1.0], [9.5, 2.0])}},
            "a.within",
            "lies beyond the domain, whose x goes from 0 to 8",
        ),
    ],
)
def test_gauges_that_cannot_be(gauges, where, text):
    case = scene(2, box([1.0, 1.0], [3.0, 3.0]), boundaries=WALLS, gauges=gauges)
    with pytest.raises(pgimp.CaseError) as error:
        pgimp.load(case)
    assert f"gauges.{where}" in str(error.value)
    assert text in str(error.value)


def test_a_plane_across_a_periodic_direction_has_a_flux_and_no_force():
    ends = {"x-min": "periodic", "x-max": "periodic"}
    body = box([0.0, 1.0], [8.0, 3.0], [0.7, 0.0])
    flux = {name: {"flux": half([at, 0.0], [1.0, 0.0])} for name, at in (("a", 0.1), ("seam", 0.0))}
    sim = start(scene(2, body, boundaries=ends, gauges=flux, end=0.1, step=0.05))
    assert sim.diagnostics()["gauge.a.mass-flux"] == pytest.approx(1.4, rel=1e-12)
    assert sim.diagnostics()["gauge.seam.mass-flux"] == pytest.approx(1.4, rel=1e-12)
    assert finish(sim).diagnostics()["gauge.a.mass-flux"] == pytest.approx(1.4, rel=1e-12)
    with pytest.raises(pgimp.CaseError, match="x-min and x-max are periodic"):
        pgimp.load(scene(2, body, boundaries=ends, gauges={"a": {"cut": flux["a"]["flux"]}}))
    spans = {"box": {"min": [0.0, 0.0], "max": [8.0, 2.0]}}
    sim = start(scene(2, body, boundaries=ends, gauges={"a": {"cut": spans}}))
    assert sim.diagnostics()["gauge.a.force-y"] == 0.0
