"""What bears a body stops it, what touches is meant to, and rigid bodies out of reach are none."""

from pathlib import Path

import pytest
from scenes import box, scene
from tiers import wide

from pgimp.case.load import load
from pgimp.case.locations import located
from pgimp.case.schema import Case
from pgimp.commands import check
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.checks import bonds, nearness
from pgimp.scene.scene import Scene

CASES = Path(__file__).parents[2] / "cases"


def said(bodies, touching=False, **parts):
    """Notes and warnings of a case of 16 x 16 cells on a wall that sticks."""
    parts = {"gravity": [0.0, -1.0], "boundaries": {"y-min": "fixed"}, "end": 5.0} | parts
    case = Case.model_validate(scene(2, bodies, cells=[16, 16], **parts))
    made = Scene(case)
    made.interaction.rigid_bodies.measure(Serial())
    lattice, counts, _ = count_particles(made, Serial())
    found = nearness.warnings(case, made.interaction.rigid_bodies)
    return [*found, *nearness.notes(case), *bonds.bonded(made, lattice, counts, touching)]


WHEEL, PLATE = box([3, 6], [7, 10]) | {"velocity": [1.0, 0.0]}, box([0, 2], [16, 6])


def test_a_body_comes_to_a_wall_only_where_nothing_bears_it():
    """A wheel on a plate, or on a rigid one; without, or beside the end of one, it falls."""
    both = {"wheel": WHEEL, "plate": box([0, 0], [16, 6])}
    contact = [{"bodies": "all"}]
    assert not said(both, contact=contact)
    fixed = {"rigid": {}, "region": PLATE["region"]}
    assert not said({"wheel": WHEEL, "plate": fixed}, contact=contact)
    for others in ({}, {"plate": {"rigid": {}, "region": box([8, 2], [16, 5])["region"]}}):
        entry = contact if others else []
        (text,) = said({"wheel": WHEEL | {"velocity": [0.0, 0.0]}} | others, contact=entry)
        assert text.startswith("boundaries.y-min: 'wheel' may approach the wall")
    # The plate and the wheel do not feel each other.
    (text,) = said(both, contact=[{"bodies": "all", "law": "ignore"}])
    assert text.startswith("boundaries.y-min: 'wheel' may approach the wall")


def test_a_float_and_lifts_on_each_other_stay_where_they_lie():
    """Water bears what swims in it; layers bear what lies on them, and are told once to touch."""
    parts = {"contact": [{"bodies": ["water", "float"]}]}
    case = {"water": box([0, 0], [16, 6]), "float": box([6, 5], [10, 8])}
    case["water"]["region"] = {
        "difference": [case["water"]["region"], {"box": {"min": [6, 5], "max": [10, 8]}}]
    }
    assert not said(case, **parts)
    lifts = {name: box([4, 2 * k], [12, 2 * k + 2]) for k, name in enumerate("abc")}
    assert not said(lifts)
    (text,) = said(lifts, touching=True)
    assert text.startswith("bodies 'a' and 'b', 'b' and 'c' touch at the start: they act as one")


@pytest.mark.parametrize("gap", [0.0, 0.5, 3.0])
def test_bodies_with_a_gap_between_them_are_warned_of(gap):
    """Those that touch are meant to act as one, those out of reach do not."""
    bodies = {"a": box([2, 0], [6, 4]), "b": box([6 + gap, 0], [11, 4])}
    found = [[text[:20] for text in said(bodies, touching)] for touching in (False, True)]
    notes = [["bodies 'a' and 'b' to"]] if gap == 0.0 else []
    assert found[0] == (["bodies: 'a' and 'b' s"[:20]] if gap == 0.5 else [])
    assert [text[:20] for text in found[1]] == [one[0][:20] for one in notes]


@pytest.mark.parametrize(("radius", "way", "warned"), [(1.5, 0.0, 0), (3.0, 0.0, 1), (1.5, 2.0, 1)])
def test_a_rigid_body_out_of_reach_is_no_pair(radius, way, warned):
    """In the bore of a tube, whose box it lies in; it may come nearer."""
    ball = {"ball": {"center": [8.0, 8.0], "radius": radius}}
    tube = {"difference": [{"ball": {"center": [8.0, 8.0], "radius": 7.0}},
                           {"ball": {"center": [8.0, 8.0], "radius": 4.5}}]}  # fmt: skip
    bodies = {
        "tube": box([0, 0], [1, 1]) | {"region": tube},
        "core": {"rigid": {"velocity": [way / 5.0, 0.0]}, "region": ball},
    }
    found = [text for text in said(bodies, gravity=[0.0, 0.0]) if "is bonded to the rigid" in text]
    assert len(found) == warned


AFFECTED = ("cavity", "excavation", "plate-impact", "rolling", "thick-tube")


@pytest.mark.parametrize(
    "path",
    [
        path if path.stem in AFFECTED else wide(path)
        for path in sorted(CASES.glob("*.yaml"))
    ],
    ids=lambda path: path.stem,
)  # fmt: skip
def test_no_case_to_start_from_has_a_warning(path, capsys, monkeypatch):
    """Nor a note that something may come near a wall, where it is not a jet that does."""
    monkeypatch.setattr(check, "measure", lambda *scene: None)
    case = load(str(path))
    with located(case):
        check.report(case)
    lines = capsys.readouterr().out.splitlines()
    assert not [line for line in lines if line.startswith("warning")]
    assert not [line for line in lines if "may come near" in line and "'jet'" not in line]
