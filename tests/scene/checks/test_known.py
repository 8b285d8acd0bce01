"""Rigid bodies beyond the domain: how far they are known, and that `check` says it."""

import pytest

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.scene.checks.rigid_motion import known_in_part
from pgimp.scene.scene import Scene

CASE = {
    "format": 1,
    "dimensions": 2,
    "grid": {"size": [0.4, 0.4], "cell": [0.02, 0.02]},
    "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
    "time": {"end": 0.5, "step": {"courant": 0.4}},
    "materials": {
        "rubber": {"model": "neo-hookean", "young": 1.0e6, "poisson": 0.3, "density": 1000.0}
    },
    "bodies": {
        "block": {
            "material": "rubber",
            "formulation": "total-lagrangian",
            "region": {"box": {"min": [0.1, 0.1], "max": [0.3, 0.3]}},
        },
        "floor": {"rigid": {}, "region": {"box": {"min": [-5.0, -5.0], "max": [5.0, -0.2]}}},
    },
    "contact": [{"bodies": ["block", "floor"]}],
}


def scene(**changes):
    made = Scene(Case.model_validate(CASE | changes))
    made.interaction.rigid_bodies.measure(Serial())
    return made


def with_floor(block=None, **floor):
    bodies = CASE["bodies"]
    return {"bodies": {"block": bodies["block"] | (block or {}), "floor": bodies["floor"] | floor}}


def test_a_large_body_is_known_in_part():
    """As far beyond the domain as it is long."""
    (text,) = known_in_part(scene())
    assert "bodies.floor.region: it is large, and known only to" in text
    assert float(text.split("known only to ")[1].split()[0]) == pytest.approx(0.4)


def test_what_moves_takes_its_surface_along():
    """On its way of 0.15 one end comes nearer to the domain; it counts where it is nearest."""
    (text,) = known_in_part(scene(**with_floor(rigid={"velocity": [0.3, 0.0]})))
    assert float(text.split("known only to ")[1].split()[0]) == pytest.approx(0.25)


@pytest.mark.parametrize(
    "changes",
    [
        with_floor(region={"box": {"min": [-0.4, -0.4], "max": [0.8, -0.2]}}),  # all of it
        with_floor(block={"formulation": "updated-lagrangian"}),  # ends at the domain
        {"contact": [{"bodies": ["block", "floor"], "law": "ignore"}]},
    ],
    ids=["small", "current", "ignored"],
)
def test_no_note_where_nothing_is_missed(changes):
    assert not [*known_in_part(scene(**changes))]
