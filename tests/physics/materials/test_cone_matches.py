"""The cone of Drucker and Prager against the strength of Mohr and Coulomb, in plane strain flow."""

from math import cos, radians, sin

import numpy as np
import pytest
from strain_paths import along


@pytest.mark.parametrize("dilation", [0.0, 10.0, 30.0])
@pytest.mark.parametrize("cohesion", [0.0, 2.0])
def test_flow_in_plane_strain_has_the_strength_of_mohr_and_coulomb(dilation, cohesion):
    """In the plane r = c cos(phi) + p sin(phi), whatever the dilation, by ``plane-strain-flow``."""
    # Volume grows as flow makes it: steady stress, with no elastic strain across the plane.
    e, grown, steps = 0.5, 0.5 * sin(radians(dilation)), 4000
    path = [
        np.diag(np.exp([-0.02 + (grown + e) * x, -0.02 + (grown - e) * x, 0.0]))
        for x in np.linspace(0.0, 1.0, steps)
    ]
    law = {
        "model": "drucker-prager", "young": 1.0e3, "poisson": 0.3, "cohesion": cohesion,
        "friction-angle": 30.0, "dilation-angle": dilation, "match": "plane-strain-flow",
    }  # fmt: skip
    xx, yy, zz, xy = along(law, np.array(path))["stress"][-1][:4]
    mean, half = -0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    assert mean > 1.0
    assert half == pytest.approx(0.5 * mean + cohesion * cos(radians(30.0)), rel=2e-3)
    if dilation == 30.0:  # along the normal: the associated match
        other = along(law | {"match": "plane-strain"}, np.array(path))["stress"][-1][:4]
        np.testing.assert_allclose(other, (xx, yy, zz, xy), rtol=1e-9)
