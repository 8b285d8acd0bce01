"""Periodic faces in a case: both of a direction, and what does not know them is refused."""

import pytest
from mentioned import mentions

from pgimp.case.reader import read_case
from pgimp.errors import CaseError

CASE = """format: 1
dimensions: 2
grid: {size: [4.0, 4.0], cell: [1.0, 1.0]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 1.0, step: 0.01}
materials: {soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}}
bodies:
  block: {material: soft, region: {box: {min: [1.0, 1.0], max: [4.0, 3.0]}}}
boundaries:
  x-min: periodic
  x-max: periodic
"""


def message(text):
    """The only line of the message about a case."""
    with pytest.raises(CaseError) as caught:
        read_case(text, "case.yaml")
    (line,) = str(caught.value).splitlines()
    return line


def test_a_case_may_be_periodic():
    assert read_case(CASE, "case.yaml").boundaries["x-max"].joins


@pytest.mark.parametrize(
    ("old", "new", "where", "parts"),
    [
        ("  x-max: periodic\n", "", "10: boundaries.x-min", ("x-max is not", "x-max: periodic")),
        ("x-min: periodic", "x-min: fixed", "11: boundaries.x-max", ("x-min is not",)),
        ("size: [4.0, 4.0]", "size: [2.0, 4.0]", "3: grid.size.0", ("2 cells are too few", "3")),
        ("  x-max: periodic", "  x-max: periodic\noutflow: {x-max: remove}", "12: outflow.x-max",
         ()),
        (
            "boundaries:",
            "tractions: {push: {body: block, face: x-max, pressure: 1.0}}\nboundaries:",
            "9: tractions.push.face", ("periodic face",),
        ),
        (
            "boundaries:",
            "body-force: {rotating-frame: {about: [0, 0], rate: 1.0}}\nboundaries:",
            "9: body-force.rotating-frame", ("depends on the position", "gravity"),
        ),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(old, new, where, parts):
    assert old in CASE
    text = CASE.replace(old, new, 1)
    if "size" in new:
        text = text.replace("max: [4.0, 3.0]", "max: [2.0, 3.0]")
    line = message(text)
    assert line.startswith(f"case.yaml:{where}: "), line
    mentions(line, *parts)


def test_unwrapped_positions_are_of_periodic_domains():
    text = CASE.replace("periodic", "slip") + "output: {fields: [unwrapped]}\n"
    mentions(message(text), "output.fields.0", "no face is periodic")


def test_a_radius_has_no_period():
    text = CASE.replace("dimensions: 2", "dimensions: 2\ngeometry: axisymmetric")
    text = text.replace("size: [4.0", "origin: [2.0, 0.0], size: [4.0")
    text = text.replace("min: [1.0, 1.0], max: [4.0", "min: [3.0, 1.0], max: [5.0")
    with pytest.raises(CaseError, match="x is the radius, which has no period"):
        read_case(text, "case.yaml")
    text = text.replace("x-min: periodic", "y-min: periodic")
    read_case(text.replace("x-max: periodic", "y-max: periodic"), "case.yaml")


def test_a_stage_keeps_it():
    stage = "stages: [{name: later, end: 2.0, boundaries: {x-min: null, x-max: null}}]"
    text = CASE.replace("step: 0.01}", f"step: 0.01, {stage}}}")
    with pytest.raises(CaseError, match="periodic from the start, or not at all"):
        read_case(text, "case.yaml")
