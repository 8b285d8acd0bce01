"""Half and quarter models whose bodies meet by their surfaces, against whole ones."""

import numpy as np
import pytest
from scenes import finish, scene, start
from tiers import wide

pytestmark = pytest.mark.slow(60)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}


def model(D, whole, soft, friction=0.0):
    """A block falls on a round obstacle, about planes at x = 0 and, in 3D, at y = 0."""
    side = 8 if D == 2 else 4
    middle, low = side * whole, -1.0 if whole else 0.0
    block = {"box": {"min": [middle + 2.4 * low] * (D - 1) + [4.2],
                     "max": [middle + 2.4] * (D - 1) + [6.3]}}  # fmt: skip
    cells = [side * (1 + whole)] * (D - 1) + [9]
    round_one = {"ball": {"centre": [middle] * (D - 1) + [2.0], "radius": 1.93}}
    within = {"box": {"min": [0] * D, "max": cells}}
    region = {"intersection": [round_one, within]} if soft else round_one
    falls = {"material": "soft", "region": block, "velocity": [0.0] * (D - 1) + [-2.0]} | EXACT
    stays = {"material": "soft", "region": region} | EXACT
    bodies = {"block": falls, "ball": stays if soft else {"rigid": {}, "region": region}}
    faces = {f"{'xyz'[D - 1]}-min": "fixed"}
    if not whole:
        faces |= {f"{axis}-min": "slip" for axis in "xy"[: D - 1]}
    return scene(D, bodies, cells=cells, step=0.01, end=0.6, boundaries=faces,
                 contact=[{"bodies": "all", "friction": friction}])  # fmt: skip


@pytest.mark.parametrize(
    ("D", "soft", "friction"),
    [(2, False, 0.0), (2, True, 0.0), (2, True, 0.3), *(wide(3, *case) for case in
     ((False, 0.0), (True, 0.0), (True, 0.3)))],
)  # fmt: skip
def test_a_half_moves_as_that_of_the_whole(D, soft, friction):
    """Nothing has a surface in a plane of symmetry, and patches beside it are as free as before.

    Patches, masters of slaves and compliance are images of each other: to rounding.
    """
    found, lines = [], []
    for whole in (True, False):
        sim = start(model(D, whole, soft, friction))
        sim.rank.contact._accuracy = 20000, 1e-13
        p, rows = finish(sim).particles, sim.live()
        begun, x = p.origin[rows].copy(), p.x[rows].copy()
        if whole:
            for values in (begun, x):
                values[:, : D - 1] -= 8 if D == 2 else 4
        own = (begun[:, : D - 1] > 0.0).all(axis=1)
        order = np.lexsort(np.column_stack([np.round(begun, 7), p.body[rows]])[own].T)
        found.append(x[own][order])
        lines.append(sim.diagnostics())
    parts = 2.0 ** (D - 1)
    for name in ("strain-energy", "kinetic-energy", "contact.all.normal-impulse"):
        assert lines[0][name] == pytest.approx(parts * lines[1][name], rel=1e-10)
    assert lines[1]["contact.all.normal-impulse"] > 1.0
    np.testing.assert_allclose(*found, rtol=0.0, atol=1e-10)
