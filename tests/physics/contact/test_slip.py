"""A law of contact that knows the velocity of slip: a lubricating film, with its exact decay."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from scenes import box, finish, scene, start
from tiers import wide

from pgimp.physics.contact import LAWS
from pgimp.physics.contact.base import ContactLaw
from pgimp.schema.base import Positive

pytestmark = pytest.mark.slow(60)


class FilmParameters(NamedTuple):
    """Shear stress over the velocity of slip."""

    viscosity: float

    @staticmethod
    def sliding_part(law, cohesion, pressed, stress, sticking, slip):
        """Part of the impulse of sticking: of a stress in proportion to the slip."""
        if pressed > 0.0 and sticking > 0.0:
            return min(1.0, law.viscosity * stress * slip / sticking)
        return 0.0

    @staticmethod
    def slope(law, pressed, stress, slip):
        """The normal impulse has no part in it."""
        return 0.0


class Film(ContactLaw):
    """A film between surfaces that touch."""

    viscosity: Positive

    def parameters(self, entry: Any) -> FilmParameters:
        """See `ContactLaw.parameters`."""
        return FilmParameters(self.viscosity)


@pytest.mark.parametrize("configuration", ["current", wide("initial")])
def test_a_film_slows_a_block_as_an_exponential(configuration, monkeypatch):
    """The rate is viscosity times area over mass, whatever the speed."""
    monkeypatch.setitem(LAWS, "film", Film)
    weight = {"table": [[0.0, [0.0, 0.0]], [1.5, [0.0, -1.0]]]}  # slowly, so that it stays down
    rates = []
    for speed in (0.5, 1.0):
        bodies = {
            "block": box([2.0, 1.0], [5.0, 4.0], [speed, 0.0]) | {"formulation": configuration},
            "plate": {"rigid": {}, "region": {"box": {"min": [-2.0, -2.0], "max": [14.0, 1.0]}}},
        }
        contact = [{"bodies": "all", "law": {"film": {"viscosity": 0.3}}}]
        case = scene(2, bodies, cells=[12, 6], end=3.0, step=0.01, gravity=weight, contact=contact)
        sim = start(case)
        while sim.time < 1.0 - 1e-9:
            sim.advance()
        before, after = sim.diagnostics()["momentum-x"], finish(sim).diagnostics()["momentum-x"]
        rates.append(0.5 * np.log(before / after))
    assert rates == pytest.approx([0.3 * 3.0 / 9.0] * 2, rel=0.015)
