"""Walls that reflect what particles carry beyond them (``wall: mirror``)."""

import numpy as np
import pytest
from transfer_setting import DT, GRAVITY, LIGHTEST, close, copied, faces_of, setting

from pgimp.kernels.data.images import Images

#: One of each kind of kernel that reaches past a wall, and one that it shares with another shape.
WIDE = ("gimp", "finite-gimp", "fuzzy-nearest", "fuzzy-constant-fixed", "bspline-quadratic")

KINDS = ("fixed", "slip", "unilateral")


def walls(D, kinds):
    """Faces from x-min on with conditions, `kinds` in turn, and the mirrors in both languages."""
    chosen = [faces_of(kinds[n % len(kinds)], D)[n] for n in range(2 * D)]
    mirrors = [
        (face[1], face[2], face[0] == "unilateral", face[0] == "fixed", n)
        for n, (_, face) in enumerate(chosen)
    ]
    mirrors.sort(key=lambda mirror: mirror[2])  # those that let go last
    kernel = [
        Images(axis, side, n, releases, sticks) for axis, side, releases, sticks, n in mirrors
    ]
    return chosen, kernel, [mirror[:4] for mirror in mirrors]


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("name", WIDE)
@pytest.mark.parametrize("kinds", [("unilateral",), KINDS], ids=["letting go", "mixed"])
def test_a_step_between_mirrors(name, D, kinds):
    """All faces at once, corners included: vertices and particles as in plain NumPy."""
    rank, reference, p = setting(name, D)
    chosen, kernel, mirrors = walls(D, kinds)
    conditions = tuple(condition for condition, _ in chosen)
    rank.particles_to_grid(conditions)
    reference.particles_to_grid(p)
    matter = reference.m > 0
    rank.update_momentum(DT, GRAVITY[:D], conditions, LIGHTEST, kernel)
    reference.update_momentum(DT, GRAVITY, [f for _, f in chosen], LIGHTEST, mirrors)
    G = rank.records()[matter]
    assert close(G[:, 1 : 1 + D], reference.v[matter])
    assert close(G[:, 5 : 5 + D], reference.a[matter])
    assert rank.grid_to_particles(DT)[0] == 0
    reference.grid_to_particles(p, rank.setting.materials, rank.setting.material_of, DT, True)
    after = copied(rank)
    for name in ("x", "v", "F", "sigma", "V"):
        assert close(getattr(after, name), getattr(p, name)), name


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("kinds", [("unilateral",), KINDS], ids=["letting go", "mixed"])
def test_particles_get_what_mirrors_say_they_give(kinds, D):
    """(28); walls that stand still do no work, and gravity's is the weight times the way."""
    rank, _, before = setting("fuzzy-constant-fixed", D)
    chosen, kernel, _ = walls(D, kinds)
    conditions = tuple(condition for condition, _ in chosen)
    rank.particles_to_grid(conditions)
    rank.update_momentum(DT, GRAVITY[:D], conditions, 0.0, kernel)
    assert rank.grid_to_particles(DT)[0] == 0
    after = copied(rank)
    m, b = before.m[:, None], np.array(GRAVITY[:D])
    gained = (m * (after.v - before.v)).sum(axis=0) - DT * m.sum() * b
    assert close(rank.impulse.sum(axis=(0, 1))[:D], gained, 1e-10)
    weight = (m * b * (after.x - before.x)).sum()
    if kinds == KINDS:
        assert close(rank.work.sum(), weight, 1e-10)
    else:  # what comes near is slowed down
        assert rank.work.sum() < weight * (1.0 + 1e-10)
