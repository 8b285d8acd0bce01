"""Bodies exact to their surface as rings, across seams, and beside mirrors."""

import numpy as np
import pytest
from scenes import finish, scene, start

from pgimp.kernels.data.motion import KEPT_MASS
from pgimp.kernels.data.record import RECORD
from pgimp.solver.lagrangian.masters import Vertices

pytestmark = pytest.mark.slow(60)

PUSH = 0.05


def box(low, high):
    return {"box": {"min": [*low], "max": [*high]}}


def ball(x, y, radius):
    return {"ball": {"centre": [x, y], "radius": radius}}


def exact(region, **more):
    """A body in the initial configuration, exact to its surface."""
    body = {
        "material": "soft",
        "region": region,
        "formulation": "total-lagrangian",
        "surface": "exact",
    }
    return body | more


def pressed(region, geometry, domain=([-1.0, 0.0], [9.0, 9.0]), **parts):
    """A body under pressure all round."""
    load = {"body": "body", "region": box(*domain), "pressure": PUSH, "follower": False}
    case = scene(2, exact(region), cells=[9, 9], tractions={"all": load}, **parts)
    case["geometry"] = geometry
    return case


ROUND = {
    "ring": box([2.37, 2.21], [5.61, 5.83]),
    "cylinder": box([0.0, 2.02], [4.03, 5.97]),
    "ball": ball(0.0, 4.53, 3.2),
    "torus": ball(4.3, 4.6, 2.7),
    "shell": {"difference": [ball(0.0, 4.53, 3.9), ball(0.0, 4.53, 1.7)]},
}


@pytest.mark.parametrize("name", ROUND)
def test_rings_under_pressure_all_round_have_its_stress(name):
    damped = {"end": 25.0, "step": 0.02, "damping": {"mass": 4.0}}
    sim = start(pressed(ROUND[name], "axisymmetric", **damped))
    assert sim.rank.slaves.courant > 0.73
    sim.advance()
    assert abs(sim.diagnostics()["momentum-y"]) < 1e-12 * PUSH
    finish(sim)
    stress = sim.particles.sigma[sim.live()]
    np.testing.assert_allclose(stress[:, :3], -PUSH, rtol=2e-3)
    np.testing.assert_allclose(stress[:, 3], 0.0, atol=2e-3 * PUSH)


def test_corners_under_pressure_all_round():
    """Parts of the surface round a corner press with both of their sides."""
    damped = {"end": 25.0, "step": 0.02, "damping": {"mass": 4.0}}
    sim = start(pressed(ROUND["ring"], "plane-strain", ([0.0, 0.0], [9.0, 9.0]), **damped))
    finish(sim)
    np.testing.assert_allclose(sim.particles.sigma[sim.live()][:, :2], -PUSH, rtol=1e-3)


def test_masses_of_rings_have_the_moments_of_the_ball():
    """Of the mass, its height and its radius, with what slaves give to their masters."""
    R, y = 3.2, 4.53
    case = scene(2, exact(ball(0.0, y, R)), cells=[9, 9])
    case["geometry"] = "axisymmetric"
    sim = start(case)
    assert len(sim.rank.slaves.keys)
    grid, frame = sim.rank.grid, sim.scene.domain.frame
    mass = grid.by_vertex(grid.kept.values)[:, 0, :, 0, KEPT_MASS]
    place = [
        np.arange(n) + low - frame.ghost
        for n, low in zip(mass.shape, grid.window.lower[:2], strict=True)
    ]
    volume = 4.0 / 3.0 * np.pi * R**3
    np.testing.assert_allclose(mass.sum(), volume, rtol=1e-4)
    np.testing.assert_allclose(mass.sum(axis=0) @ place[1], volume * y, rtol=1e-4)
    np.testing.assert_allclose(mass.sum(axis=1) @ place[0], np.pi**2 * R**4 / 4.0, rtol=1e-4)


def across(shift, volumetric="pointwise"):
    """A block that moves and is pressed, in a domain that is periodic along x and y, and shifted.

    Returns its particles at the end, in the order of their places before the shift.
    """
    L, low, high = (
        np.array([9.0, 8.0]),
        np.array([2.97, 2.31]) + shift,
        np.array([6.02, 5.63]) + shift,
    )
    parts = [
        box(np.maximum(low - L * k, 0.0), np.minimum(high - L * k, L))
        for k in (np.array(each) for each in ((0, 0), (1, 0), (0, 1), (1, 1)))
        if (low - L * k < L).all() and (high - L * k > 0.0).all()
    ]
    load = {"body": "body", "region": box([0.0, 0.0], L), "pressure": PUSH}
    case = scene(
        2, exact(parts[0] if len(parts) == 1 else {"union": parts}, velocity=[0.3, 0.2]),
        cells=[9, 8], end=0.8, step=0.02, tractions={"t": load},
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min", "y-max"), "periodic"),
    )  # fmt: skip
    case["method"]["volumetric"] = volumetric
    sim = start(case)
    slaves = len(sim.rank.slaves.keys)
    finish(sim)
    p, rows = sim.particles, sim.live()
    order = np.lexsort(np.round((p.origin[rows] - shift) % L, 6).T)
    return slaves, np.hstack([p.v[rows], p.sigma[rows], p.F[rows]])[order]


@pytest.mark.parametrize("volumetric", ["pointwise", pytest.param("mean", marks=pytest.mark.wide)])
@pytest.mark.parametrize("shift", [(5.0, 0.0), (0.0, 4.0), (5.0, 4.0), (4.0, 5.0)])
def test_a_body_across_seams_is_the_same_body(shift, volumetric):
    """Also where masters are on the other side of a seam."""
    slaves, found = across(np.array(shift), volumetric)
    first, truth = across(np.zeros(2), volumetric)
    assert slaves == first > 4
    np.testing.assert_allclose(found, truth, atol=1e-12)


@pytest.mark.parametrize("shift", [(2.0, 0.0), (5.0, 4.0)])
def test_cells_share_their_dilatation_across_seams(shift):
    slaves, found = across(np.array(shift), "mean")
    first, truth = across(np.zeros(2), "mean")
    assert slaves == first > 4
    np.testing.assert_allclose(found, truth, atol=1e-12)


@pytest.mark.parametrize("top", [4.374, 4.02, 4.6])
def test_half_a_body_beside_a_mirror_is_the_whole(top):
    """Vertices on the mirror hold half of what the whole body's do, and are slaves as these are."""
    found = []
    for half in (True, False):
        low = 0.0 if half else -5.0
        region = box([max(low, -2.6), 1.33], [2.6, top])
        load = {"body": "body", "region": box([low, 3.0], [5.0, 9.0]), "pressure": PUSH}
        case = scene(
            2, exact(region), cells=[5 if half else 10, 9], end=1.0, step=0.02,
            tractions={"t": load}, gravity=[0.0, -0.1],
            boundaries={"x-min": "slip"} if half else {},
        )  # fmt: skip
        case["grid"]["origin"] = [low, 0.0]
        sim = start(case)
        x = Vertices.numbers(sim.rank, sim.rank.slaves.keys)[0] - sim.scene.domain.frame.ghost + low
        finish(sim)
        p, rows = sim.particles, sim.live()
        rows = rows[p.origin[rows, 0] > 0.0]
        order = np.lexsort(p.origin[rows].T)
        kept = sim.rank.grid.kept.values.reshape(-1, RECORD)[:, KEPT_MASS]
        found.append((np.sum(x >= 0), np.hstack([p.v[rows], p.sigma[rows]])[order], kept.sum()))
    (slaves, values, mass), (whole_slaves, whole, whole_mass) = found
    assert slaves == whole_slaves
    np.testing.assert_allclose(2.0 * mass, whole_mass, rtol=1e-12)
    np.testing.assert_allclose(values, whole, atol=1e-12)
