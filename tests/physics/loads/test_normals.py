"""Loads by the direction of the surface: what is taken, and entries that are refused."""

import numpy as np
import pytest
from pydantic import ValidationError

from pgimp.physics.loads.surfaces import Normal
from pgimp.physics.loads.tractions import TractionEntry

REGION = {"box": {"min": [0.0, 0.0], "max": [1.0, 1.0]}}


def test_parts_within_an_angle():
    angles = np.radians([0.0, 29.0, 31.0, 90.0, 180.0])
    area = 0.3 * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    up = Normal.model_validate({"of": [0.0, 2.0]})
    assert up.includes(area).tolist() == [True, True, False, False, False]
    assert Normal.model_validate({"of": [0.0, 2.0], "within": 180.0}).includes(area).all()


@pytest.mark.parametrize(
    ("entry", "text"),
    [
        ({"region": REGION, "normal": {"of": [0.0, 0.0]}}, "not a vector of length zero"),
        ({"region": REGION, "normal": {"of": [1.0, 0.0], "within": 200.0}}, "180"),
        ({"face": "x-max", "normal": {"of": [1.0, 0.0]}}, "is for a load with a `region`"),
    ],
)
def test_normals_that_are_refused(entry, text):
    with pytest.raises(ValidationError, match=text):
        TractionEntry.model_validate({"body": "b", "pressure": 1.0} | entry)
