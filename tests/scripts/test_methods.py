"""scripts/methods: its reference beam, and that docs/methods.md has what it measures."""

import re
from math import cos, cosh, sin, sinh, sqrt

import numpy as np
import pytest
from studies.method import measures, table, timoshenko
from studies.method.bodies import Method
from tiers import wide

pytestmark = pytest.mark.slow(30)


def test_a_slender_beam_swings_as_eulers():
    """1.8751 is the first root of cos k cosh k = -1; shear matters by (height/length)^2."""
    k = 1.87510407
    rate, nodes, deflection, rotation = timoshenko.slowest(400.0, 4.0)
    assert rate == pytest.approx(k**2 / 400.0**2 * 4.0 / sqrt(12.0), rel=4e-4)
    share = (sinh(k) - sin(k)) / (cosh(k) + cos(k))
    for x, found in zip(k * nodes / 400.0, deflection, strict=True):
        exact = 0.5 * (cosh(x) - cos(x) - share * (sinh(x) - sin(x)))
        assert found == pytest.approx(exact, abs=1e-3)
    np.testing.assert_allclose(rotation, np.gradient(deflection, nodes), atol=1e-4)


def test_the_beams_reference_has_converged():
    coarse, fine = (timoshenko.slowest(24.0, 4.0, n)[0] for n in (160, 320))
    assert coarse == pytest.approx(fine, rel=2e-5)


def printed(method):
    """Cells of a method's line in the first table of docs/methods.md, by title."""
    text = table.TABLES.read_text(encoding="utf-8")  # a test holds the page to it
    (titles, line) = (re.search(rf"^\| {name} \|.*$", text, re.M)[0] for name in ("method", method))
    return dict(zip(titles.split(" | "), line.split(" | "), strict=True))


@pytest.mark.parametrize("more", ["", wide(", affine"), wide(", initial")])
def test_the_page_has_what_is_measured(more):
    """In 2D, to the digits printed; what rounds otherwise on another CPU is far smaller."""
    cells = printed(f"gimp{more}, 2 a cell")
    configuration = "initial" if more == ", initial" else "current"
    method = Method("gimp", more == ", affine", configuration=configuration)
    bending = measures.bending(method, 2, measures.COURANTS[:1])
    spin = measures.turned(method, 2, measures.COURANTS[:1])
    for title, value, sign in (
        ("bending", bending["frequency"], True),
        ("swing", bending["swing 0.3"], False),
        ("bounce", measures.bounced(method, 2)["bounce"], False),
        ("spin", spin["spin 0.3"], False),
    ):
        assert cells[title].partition(",")[0] == table.number(value, sign), title
