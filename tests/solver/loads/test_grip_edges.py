"""Vertices that grips hold, against plain NumPy: parts of masses, the nearest ones, all."""

import numpy as np
import pytest
from scenes import box, field, scene, start
from tiers import wide

from pgimp.solver.state.vertex_motion import begin_motion

pytestmark = pytest.mark.slow(40)

HALF = 0.25  # of a particle, in cells


def hat(d):
    """Linear shape function."""
    return np.maximum(1.0 - np.abs(d), 0.0)


def boxed(d):
    """Mean of `hat` over a particle's box, by its antiderivative."""

    def integral(x):
        x = np.clip(x, -1.0, 1.0)
        return x - np.sign(x) * 0.5 * x**2

    return (integral(d + HALF) - integral(d - HALF)) / (2.0 * HALF)


SHAPES = {"gimp": boxed, "cpdi": lambda d: 0.5 * (hat(d - HALF) + hat(d + HALF))}


def held_block(shape, configuration, **motion):
    """A block of 4 x 2 between grips that turn, of which one may move otherwise."""
    turning = {"rotation": {"about": [4.0, 4.0], "rate": 2.0}, "velocity": [0.4, 0.25]}
    ends = {"left": ([2.0, 3.0], [3.5, 5.0]), "right": ([4.5, 3.0], [6.0, 5.0])}
    grips = {
        name: {"body": "body", "region": {"box": {"min": low, "max": high}}}
        | (motion if motion and name == "left" else turning)
        for name, (low, high) in ends.items()
    }
    body = box([2.0, 3.0], [6.0, 5.0]) | {"formulation": configuration}
    return scene(2, body, shape=shape, step=0.01, constraints=grips)


def holding(sim):
    """Coordinates of the window's vertices along x and y, and the constraints that hold them."""
    grid = sim.rank.grid
    first = np.array(grid.window.lower[:2]) - grid.frame.ghost
    size = grid.planes, grid.window.extent[1]
    along = [n + np.arange(count) for n, count in zip(first, size, strict=True)]
    return along, grid.marks[0].reshape(size)


@pytest.mark.parametrize(
    ("shape", "configuration", "heavy", "force"),
    [
        ("gimp", "initial", 1.0, None),
        ("gimp", "initial", 1e6, None),
        ("gimp", "current", 1e6, None),
        ("gimp", "initial", 1e6, 1.0),
        wide("cpdi", "initial", 1e6, None),
    ],
)
def test_grips_hold_what_numpy_says(shape, configuration, heavy, force):
    """Also where the free part is so heavy that a grip's mass is as nothing: the nearest ones."""
    motion = {"force": [force, None]} if force else {}
    sim = start(held_block(shape, configuration, **motion))
    p, rows = sim.particles, sim.live()
    p.m[rows] *= np.where(p.constraint[rows, 0] > 0, 1.0, heavy)
    begin_motion(sim.rank)  # masses are those of the start
    x, held, m = field(sim, "x"), field(sim, "constraint")[:, 0], field(sim, "m")
    sim.advance()
    along, marks = holding(sim)
    S = [SHAPES[shape](x[:, d, None] - along[d]) for d in range(2)]
    near = [1.0 * (np.abs(x[:, d, None] - along[d]) <= 0.5 + 1e-9) for d in range(2)]
    total = np.einsum("p,pi,pj->ij", m, *S)
    part = np.einsum("p,pi,pj->ij", m * (held > 0), *S) / np.maximum(total, 1e-9)
    kept = np.einsum("p,pi,pj->ij", 1.0 * (held > 0), *near) > 0
    if force:
        kept |= np.einsum("pi,pj->ij", *(each[held == 1] >= 1e-9 for each in S))
    if configuration == "current":
        kept[:] = True
    assert (kept | (np.abs(part - 0.1) > 1e-3) | (total == 0.0)).all()
    released = 0
    for k in (1, 2):
        reached = np.einsum("pi,pj->ij", *(each[held == k] >= 1e-9 for each in S))
        holds = reached & (kept | (part > 0.1))
        np.testing.assert_array_equal(marks >> (k - 1) & 1 == 1, holds)
        released += (reached & ~holds).sum()
    assert (marks >> 2 == 0).all()
    assert (released > 0) == (heavy > 1.0 and configuration == "initial" and not force)


def test_a_disk_between_round_grips_is_as_stiff_as_it_is():
    """Held within 3 cells and turned beyond 7: Lame's moment; with all that they reach 1.42 of it.

    M = 4 pi G angle/(1/a^2 - 1/b^2).
    """
    c, angle = [10.0, 10.0], 2e-3
    hole, disk, beyond = ({"ball": {"center": c, "radius": r}} for r in (3.0, 8.5, 9.0))
    outer = {"difference": [beyond, {"ball": {"center": c, "radius": 7.0}}]}
    rate = {"table": [[0.0, 0.0], [8.0, angle / 8.0], [16.0, 0.0]]}
    grips = {
        "inner": {"body": "body", "region": hole, "rotation": {"about": c, "rate": 0.0}},
        "outer": {"body": "body", "region": outer, "rotation": {"about": c, "rate": rate}},
    }  # fmt: skip
    body = {"material": "soft", "region": disk, "formulation": "total-lagrangian"}
    sim = start(scene(2, body, cells=[20, 20], end=20.0, step={"courant": 0.5}, constraints=grips,
                      damping={"mass": 0.5}))  # fmt: skip
    while not sim.finished:
        sim.advance()
        if sim.time < 18.0:
            sim.diagnostics()
    moment = sim.diagnostics()["torque.outer-z"]  # a mean over the last two units of time
    exact = 4.0 * np.pi * 100.0 / 2.6 * angle / (3.0**-2 - 7.0**-2)
    assert moment == pytest.approx(exact, rel=0.06)
