"""A shape that a test registers: checks and advice go by its attributes, not by its name."""

from typing import ClassVar, Literal

import pytest
from checked import PLATE
from mentioned import mentions
from pydantic import Field

from pgimp.case.reader import read_case
from pgimp.case.stepping.courant import largest_courant
from pgimp.commands import check
from pgimp.physics.shapes import SHAPES
from pgimp.physics.shapes.fuzzy import FuzzyConstant
from pgimp.physics.shapes.gimp import Gimp
from pgimp.physics.shapes.mpm import Mpm


class Dots(Mpm):
    """Points by another name."""

    shape: Literal["dots"] = Field(description="name of the shape")


class Tiles(Gimp):
    """Boxes by another name, with limits of their own."""

    shape: Literal["tiles"] = Field(description="name of the shape")

    limits: ClassVar[dict[str, dict[int, dict[int, float]]]] = {
        "": {2: {2: 0.31, 4: 0.2}}, "affine": {2: {2: 0.41}}, "vertices": {2: {2: 0.51}}
    }  # fmt: skip


class Clouds(FuzzyConstant):
    """Wide tents by another name."""

    shape: Literal["clouds"] = Field(description="name of the shape")


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    """The shapes above, and a report without what compiles and measures."""
    for kind in (Dots, Tiles, Clouds):
        name = kind.model_fields["shape"].annotation.__args__[0]
        monkeypatch.setitem(SHAPES, name, kind)
    monkeypatch.setattr(check, "measure", lambda *scene: None)
    monkeypatch.setattr(check, "pilot", lambda *case: None)


def report(capsys, shape, *overrides):
    """What `pgimp check` says of a plate that moves far, with the shape."""
    end = ["time.end=100.0", f"method.shape={shape}", "bodies.beam.velocity=[0.1, 0.0]"]
    check.report(read_case(PLATE, "case.yaml", [*end, *overrides]))
    return capsys.readouterr().out


@pytest.mark.parametrize(("name", "like"), [("dots", "mpm"), ("tiles", "gimp")])
@pytest.mark.parametrize("overrides", [(), ("method.affine=true",)], ids=["plain", "affine"])
def test_it_is_checked_as_what_it_is_like(name, like, overrides, capsys):
    fixed = ("time.step=0.001", *overrides)
    said = report(capsys, name, *fixed)
    expected = report(capsys, like, *fixed)
    apart = "{courant: auto}", "memory"  # of the shape's own table; what else is running
    lines = (
        [one for one in text.splitlines() if not any(each in one for each in apart)]
        for text in (said.replace(name, like), expected)
    )
    assert next(lines) == next(lines)


def test_points_and_wide_shapes_are_advised_by_name(capsys):
    mentions(report(capsys, "dots"), "method.shape: dots: 'beam' will cross cells")
    mentions(report(capsys, "clouds"), "method.shape: clouds: 'beam': elastic, and moves")


def test_limits_are_the_shapes_own():
    for overrides, limit in (((), 0.31), (("method.affine=true",), 0.41), (("n=4",), 0.2)):
        values = [one.replace("n=", "method.particles-per-cell.0=") for one in overrides]
        case = read_case(PLATE, "case.yaml", ["method.shape=tiles", *values])
        assert largest_courant(case) == limit
    initial = ["method.shape=tiles", "bodies.beam.formulation=total-lagrangian"]
    assert largest_courant(read_case(PLATE, "case.yaml", initial)) <= 0.51
