"""Rigid bodies that are refused, or of which a run warns."""

import pytest
from rams import rigid, struck
from scenes import box, scene, start

import pgimp
from pgimp.commands import check
from pgimp.errors import CaseError, UsageError
from pgimp.scene.rigid.checks import require_same


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rigid": {"speed": 1.0}}, "speed"),
        ({"rigid": {"velocity": [1.0]}}, "bodies.ram.rigid.velocity"),
        ({"rigid": {"rotation": {"about": [1.0, 1.0], "axis": [1.0, 0.0, 0.0], "rate": 1.0}}},
         "in 2D the axis is z"),
        ({"material": "soft"}, "bodies.ram.material"),
        ({"velocity": [1.0, 0.0]}, "bodies.ram.velocity"),
        ({"region": {"half-space": {"point": [3.0, 3.0], "normal": [1.0, 0.0]}}}, "has no end"),
        ({"region": {"box": {"min": [1.5, 1.0], "max": [2.0, 6.0]}}}, "0.5 thick"),
        ({"region": {"box": {"min": [1.5, 1.0], "max": [5.5, 6.0]}}}, "'block' reaches 1.5 into"),
        ({"region": {"box": {"min": [1.5, 1.0], "max": [4.3, 6.0]}}}, "'block' reaches 0.3 into"),
        ({"region": {"box": {"min": [1.5, 1.0], "max": [4.1, 6.0]}}}, "'block' reaches 0.1 into"),
        ({"region": {"box": {"min": [5.0, 3.0], "max": [6.0, 4.0]}}}, "'block' reaches 2 into"),
        ({"region": {"points": {"file": "a.csv"}}}, "rigid body has no particles"),
        ({"rigid": {"velocity": [200.0, 0.0]}}, "moves by 2 cells in a step"),
        ({"rigid": {"rotation": {"about": [2.5, 3.0], "rate": 100.0}}}, "cells in a step"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(change, said):
    case = struck(2, {"friction": 0.1})
    case["bodies"]["ram"] = case["bodies"]["ram"] | change
    with pytest.raises((CaseError, ValueError)) as raised:
        start(case)
    assert said in str(raised.value)


@pytest.mark.parametrize("region", [
    {"box": {"min": [1.5, 1.0], "max": [4.0, 6.0]}},
    {"box": {"min": [1.5, 1.0], "max": [4.04, 6.0]}},
    {"ball": {"centre": [2.1, 3.4], "radius": 1.9}},
    # A wedge, whose point touches: distances from its planes are much less than from the point.
    {"intersection": [
        {"box": {"min": [1.0, 1.0], "max": [4.0, 6.0]}},
        {"half-space": {"point": [4.0, 3.5], "normal": [1.0, 2.0]}},
        {"half-space": {"point": [4.0, 3.5], "normal": [1.0, -2.0]}},
    ]},
])  # fmt: skip
def test_what_touches_is_not_refused(region):
    """A flat face, a round one, and the point of a wedge."""
    case = struck(2, {"friction": 0.1})
    case["bodies"]["ram"] |= {"region": region}
    start(case)


def test_contact_of_rigid_bodies_alone_is_refused():
    """They do not feel each other, and an entry for them would be thought to do something."""
    case = struck(2, {"friction": 0.1})
    case["bodies"]["wall"] = rigid([10.0, 1.0], [12.0, 6.0])
    case["contact"].append({"bodies": ["ram", "wall"]})
    with pytest.raises((CaseError, ValueError), match=r"contact\.1\.bodies\s+all are rigid"):
        start(case)


def test_a_run_goes_on_with_the_same_rigid_bodies_only():
    sim = start(struck(2, {"friction": 0.1}))
    other = struck(2, {"friction": 0.1})
    other["bodies"]["ram"]["region"]["box"]["min"][0] = 1.0
    assert (
        sim.scene.interaction.rigid_bodies.checksum
        != start(other).scene.interaction.rigid_bodies.checksum
    )
    require_same(sim.scene.interaction.rigid_bodies, sim.scene.interaction.rigid_bodies.checksum)
    with pytest.raises(UsageError, match="has the file of a mesh changed"):
        require_same(
            sim.scene.interaction.rigid_bodies, start(other).scene.interaction.rigid_bodies.checksum
        )


def test_nothing_but_contact_may_name_a_rigid_body():
    case = struck(2, {"friction": 0.1})
    case["constraints"] = {
        "grip": {"body": "ram", "region": {"box": {"min": [0.0, 0.0], "max": [9.0, 8.0]}},
                 "velocity": [0.0, 0.0]}
    }  # fmt: skip
    with pytest.raises(ValueError, match=r"constraints\.grip\.body"):
        start(case)
    alone = struck(2, {})
    del alone["bodies"]["block"], alone["contact"]
    with pytest.raises(ValueError, match="needs a body of a material"):
        start(alone)


@pytest.mark.parametrize(("rigid", "speed"), [
    ({"velocity": [0.0, -3.0]}, 0.0),
    ({"velocity": {"table": [[0.0, [0.0, 0.0]], [9.0, [0.0, -6.0]]]}}, 6.0),
    ({"rotation": {"about": [4.0, 6.5], "rate": 3.0}}, 6.0),
    ({"density": 1.0}, 0.0),
])  # fmt: skip
def test_rigid_bodies_that_are_fast_for_waves_are_warned_of(rigid, speed):
    """Waves of 11.6; the one that turns is a ball of R = 2."""
    bodies = {
        "block": box([2.0, 1.0], [6.0, 4.0]),
        "punch": {"rigid": rigid, "region": {"ball": {"centre": [4.0, 6.5], "radius": 2.0}}},
    }
    case = scene(2, bodies, cells=[8, 12], step={"courant": 0.3}, contact=[{"bodies": "all"}])
    said = [text for text in start(case).warnings if text.startswith("bodies.punch.rigid")]
    assert len(said) == bool(speed)
    for text in said:
        assert float(text.split("up to ")[1].split(",")[0]) == pytest.approx(speed, rel=0.02)
        assert "waves in 'block' (11.6)" in text


BAR = {"box": {"min": [-2.0, 6.0], "max": [4.0, 8.0]}}
INSIDE = {"box": {"min": [2.0, 6.0], "max": [4.0, 8.0]}}
BEHIND = {"box": {"min": [-4.0, 6.0], "max": [-1.0, 8.0]}}
ROLLER = {"ball": {"centre": [0.0, 8.0], "radius": 2.0}}
TOUCHING = {"ball": {"centre": [2.0, 8.0], "radius": 2.0}}
TO_AND_FRO = {"velocity": {"table": [[0.0, [2.0, 0.0]], [1.0, [-2.0, 0.0]]]}}


@pytest.mark.parametrize(("region", "motion", "said"), [
    (BAR, {"velocity": [3.0, 0.0]}, "through the slip wall x-min by t = 0.6"),  # 1.95/3
    (BAR, {"velocity": [-4.0, 0.0]}, "through the slip wall x-min by t = 0.7"),  # 3/4
    (INSIDE, {"velocity": [-3.0, 0.0]}, "through the slip wall x-min by t = 0.6"),  # 2.05/3
    (BEHIND, {"velocity": [4.0, 0.0]}, "through the slip wall x-min by t = 0.5"),  # 2/4
    (ROLLER, {"rotation": {"about": [0.0, 8.0], "rate": 1.0}}, "turns on the slip wall x-min"),
    # A piston, a punch that slides along the wall, a roller on it, a body that stands or lets go.
    (BAR, TO_AND_FRO, ""),
    (BAR, {"velocity": [0.0, -1.0]}, ""),
    (TOUCHING, {"rotation": {"about": [2.0, 8.0], "rate": 1.0}}, ""),
    (BAR, {}, ""),
    ({"box": {"min": [0.0, 6.0], "max": [4.0, 8.0]}}, {"velocity": [3.0, 0.0]}, ""),
])  # fmt: skip
def test_motions_that_a_plane_of_symmetry_forbids_are_warned_of(region, motion, said, capsys):
    """By a run and by check; also if the wall begins in a later stage."""
    bodies = {"block": box([2.0, 1.0], [6.0, 4.0]), "punch": {"rigid": motion, "region": region}}
    case = scene(
        2, bodies, cells=[8, 12], step={"courant": 0.3}, contact=[{"bodies": "all"}],
        boundaries={"x-min": "slip"}, end=1.0,
    )  # fmt: skip
    found = [text for text in start(case).warnings if "slip wall" in text]
    assert len(found) == bool(said)
    assert all(text.startswith("bodies.punch.rigid: it ") and said in text for text in found)
    for condition in ("fixed", "unilateral"):
        other = case | {"boundaries": {"x-min": condition}}
        assert not any("slip wall" in text for text in start(other).warnings)
    if region is INSIDE:
        case["boundaries"] = {}
        case["time"]["stages"] = [{"name": "b", "end": 2.0, "boundaries": {"x-min": "slip"}}]
        case["time"]["end"] = 0.5
        assert any("through the slip wall" in text for text in start(case).warnings)
        check.report(pgimp.load(case))
        assert "through the slip wall x-min by t = 0.6" in capsys.readouterr().out
