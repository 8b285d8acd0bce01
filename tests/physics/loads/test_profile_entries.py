"""Profiles of loads that cannot be, and those that go round."""

import re

import pytest

from pgimp.case.reader import read_case
from pgimp.errors import CaseError

TEXT = """format: 1
dimensions: 2
grid: {size: [9, 9], cell: [1, 1]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 1.0, step: 0.01}
materials: {soft: {model: hooke, young: 1.0, poisson: 0.0, density: 1.0}}
bodies: {block: {material: soft, region: {box: {min: [1, 1], max: [5, 5]}}}}
tractions:
  train:
    body: block
    region: {half-space: {point: [0, 4.5], normal: [0, -1]}}
    pressure: 1.0
    profile:
      along: [1, 0]
      from: [2, 0]
      velocity: 20.0
      table: [[-0.5, 0.0], [0.5, 1.0]]
"""


ROWS = "[[-0.5, 0.0], [0.5, 1.0]]"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (ROWS, "[]", ("17: tractions.train.profile.table:", "two rows", "none")),
        (ROWS, "[[0, 1]]", ("17: tractions.train.profile.table:", "two rows", "got 1")),
        (ROWS, "[[0, 1], [0, 2]]", ("17: tractions.train.profile.table.1.0:", "must increase")),
        (ROWS, "[[0, 1], [-1, 2]]", ("17: tractions.train.profile.table.1.0:", "coordinates")),
        (ROWS, "[[0, 1], [1, 2, 3]]", ("17: tractions.train.profile.table.1:", "2 entries")),
        ("g: [1, 0]", "g: [0, 0]", ("14: tractions.train.profile.along:", "length zero")),
        ("g: [1, 0]", "g: [1, 0, 0]", ("14: tractions.train.profile.along:", "2 entries")),
        ("      along: [1, 0]\n", "", ("13: tractions.train.profile.along:", "missing")),
        ("m: [2, 0]", "m: [2]", ("15: tractions.train.profile.from:", "2 entries")),
        ("y: 20.0", "y: [20.0, 0]", ("16: tractions.train.profile.velocity:", "a number")),
        ("velocity: 20.0", "beyond: keep", ("16: tractions.train.profile.beyond:", "hold")),
        ("region: {half-space: {point: [0, 4.5], normal: [0, -1]}}", "face: y-max",
         ("13: tractions.train.profile:", "with a `region`", "in place of face")),
        ("pressure: 1.0", "hydrostatic: {level: 1.0, density: 1.0}",
         ("13: tractions.train.profile:", "take `pressure`")),
        ("materials:", "boundaries: {x-min: periodic, x-max: periodic}\nmaterials:",
         ("15: tractions.train.profile.along:", "periodic", "along these faces")),
    ],
)  # fmt: skip
def test_wrong_profiles_are_refused_with_line_and_advice(old, new, words):
    assert old in TEXT and read_case(TEXT, "c.yaml")
    with pytest.raises(CaseError) as caught:
        read_case(TEXT.replace(old, new), "c.yaml")
    (line,) = [each for each in str(caught.value).splitlines() if "profile" in each]
    assert line.startswith(f"c.yaml:{words[0]}") and all(word in line for word in words[1:]), line


def test_a_profile_goes_along_periodic_faces():
    text = TEXT.replace("along: [1, 0]", "along: [0, 1]")
    text = text.replace("materials:", "boundaries: {x-min: periodic, x-max: periodic}\nmaterials:")
    case = read_case(text, "c.yaml")
    assert re.search("along", str(case.tractions["train"].profile))
