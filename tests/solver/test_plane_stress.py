"""Plane stress: against plane strain of other moduli, the laws themselves, and plates in 3D."""

import numpy as np
import pytest
from tiers import wide

import pgimp
from pgimp.case.schema import Case

pytestmark = pytest.mark.slow(90)

YOUNG, POISSON = 100.0, 0.3
LAWS = {"hooke": {}, "neo-hookean": {}, "von-mises": {"yield-stress": 1.0, "hardening": 20.0}}


def case(law, *, geometry="plane-stress", young=YOUNG, poisson=POISSON, more=(), **parts):
    """A beam that is held at one end, and sways."""
    method = {"shape": "gimp", "particles-per-cell": [2, 2]} | parts.pop("method", {})
    body = {"material": "m", "region": {"box": {"min": [0.0, 1.0], "max": [4.0, 2.0]}}}
    return {
        "format": 1,
        "dimensions": 2,
        "geometry": geometry,
        "grid": {"size": [6.0, 3.0], "cell": [0.25, 0.25]},
        "method": method,
        "time": {"end": 4.0, "step": 0.005},
        "materials": {
            "m": {"model": law, "young": young, "poisson": poisson, "density": 1.0}
            | LAWS[law] | dict(more)
        },
        "bodies": {"b": body | parts.pop("body", {})},
        "boundaries": {"x-min": "fixed"},
    } | parts  # fmt: skip


def loaded(along, across):
    """A traction at the free end, from the first step on."""
    return {"tractions": {"pull": {"body": "b", "face": "x-max", "traction": [along, across]}}}


@pytest.mark.parametrize("configuration", ["current", "initial"])
@pytest.mark.parametrize(
    ("law", "method"),
    [
        wide("hooke", {"affine": True}),
        ("neo-hookean", {}),
        wide("neo-hookean", {"shape": "cpdi"}),
        ("von-mises", {"shape": "finite-gimp"}),
    ],
)
def test_small_motions_are_those_of_plane_strain_with_other_moduli(law, method, configuration):
    """E (1 + 2 nu)/(1 + nu)^2 and nu/(1 + nu) there: all differences are of second order."""
    young = YOUNG * (1.0 + 2.0 * POISSON) / (1.0 + POISSON) ** 2
    found = []
    for moduli in (
        {"geometry": "plane-stress"},
        {"geometry": "plane-strain", "young": young, "poisson": POISSON / (1.0 + POISSON)},
    ):
        scene = case(law, method=method, body={"formulation": configuration}, **moduli)
        sim = pgimp.Simulation(scene | loaded(3e-6, 1e-5))
        start = sim.particles["position"]
        sim.advance()
        found.append(sim.particles["position"] - start)
    most = np.abs(found[1]).max()
    assert 1e-5 < most < 1e-4
    assert np.abs(found[0] - found[1]).max() < 1e-4 * most  # the strain, times the way along it


def root(function, low, high):
    """The root of a growing function, by bisection."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if function(middle) > 0.0 else (middle, high)
    return middle


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_the_thickness_obeys_the_law(configuration):
    """Each particle's F solves s_zz = 0 of the neo-Hookean law, by bisection."""
    scene = case("neo-hookean", body={"formulation": configuration}) | loaded(9.0, 0.3)
    sim = pgimp.Simulation(scene)
    sim.advance()
    F = sim.particles["deformation"].reshape(-1, 3, 3)
    mu = YOUNG / (2.0 * (1.0 + POISSON))
    lam = 2.0 * mu * POISSON / (1.0 - 2.0 * POISSON)
    areas = np.linalg.det(F[:, :2, :2])
    for area, thickness in zip(areas[::7], F[::7, 2, 2], strict=True):
        wanted = root(lambda f, a=area: mu * (f * f - 1.0) + lam * np.log(a * f), 0.2, 5.0)
        assert thickness == pytest.approx(wanted, abs=1e-11)
    assert np.abs(areas - 1.0).max() > 0.1
    assert np.abs(sim.particles["stress"][:, 2]).max() < 1e-10 * YOUNG
    volume = areas * F[:, 2, 2] * sim.particles["mass"]
    np.testing.assert_allclose(sim.particles["volume"], volume, rtol=1e-12)


def test_rubber_may_be_stretched_by_far():
    """Drawn out to nine times its length: the slope is a hundredth of the fastest wave's."""
    scene = case(
        "neo-hookean",
        body={"formulation": "total-lagrangian", "region": {"box": {"min": [0, 1], "max": [1, 2]}}},
        grid={"size": [12.0, 3.0], "cell": [0.25, 0.25]}, time={"end": 8.0, "step": 0.002},
        method={"shape": "cpdi"}, damping={"mass": 4.0},
        constraints={"grip": {
            "body": "b", "velocity": [1.0, None],
            "region": {"half-space": {"point": [0.7, 0.0], "normal": [-1.0, 0.0]}},
        }},
    )  # fmt: skip
    sim = pgimp.Simulation(scene)
    sim.advance()
    assert sim.particles["deformation"][:, 0].max() > 8.0
    assert np.abs(sim.particles["stress"][:, 2]).max() < 1e-8 * YOUNG


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_what_flows_is_on_its_yield_surface(configuration):
    """And loses volume by elastic strain alone: log J = s_kk/(3 K)."""
    scene = case("von-mises", body={"formulation": configuration}) | loaded(0.3, 0.06)
    sim = pgimp.Simulation(scene)
    sim.advance()
    s, J = sim.particles["stress"], np.linalg.det(sim.particles["deformation"].reshape(-1, 3, 3))
    strain = sim.particles["plastic-strain"]
    flows = strain > 1e-3
    assert flows.sum() > 20
    assert np.abs(s[:, 2]).max() < 1e-10 * YOUNG
    bulk = YOUNG / (3.0 * (1.0 - 2.0 * POISSON))
    kirchhoff = J[:, None] * s
    np.testing.assert_allclose(kirchhoff[:, :3].sum(axis=1), 3.0 * bulk * np.log(J), atol=1e-9)
    xx, yy, zz, xy = kirchhoff[:, :4].T
    q = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * xy**2)
    assert (q <= (1.0 + 20.0 * strain) * (1.0 + 1e-9)).all()
    assert np.isclose(q[flows], 1.0 + 20.0 * strain[flows], rtol=1e-9).any()


@pytest.mark.wide
def test_a_thin_plate_in_space_moves_alike():
    """A block one cell thick, free on both sides, of stiff rubber that stretches by a tenth."""
    parts = {"body": {"formulation": "total-lagrangian"}, "time": {"end": 3.0, "step": 0.005}}
    flat = pgimp.Simulation(case("neo-hookean", **parts) | loaded(0.3, 1.0))
    flat.advance()
    scene = case("neo-hookean", geometry="plane-strain", **parts)
    scene["dimensions"], scene["grid"] = 3, {"size": [6.0, 3.0, 0.25], "cell": [0.25, 0.25, 0.25]}
    scene["method"]["particles-per-cell"] = [2, 2, 2]
    scene["grid"] |= {"origin": [0.0, 0.0, -0.25], "size": [6.0, 3.0, 0.75]}
    scene["bodies"]["b"]["region"] = {"box": {"min": [0.0, 1.0, 0.0], "max": [4.0, 2.0, 0.25]}}
    scene["boundaries"] = {"x-min": {"velocity": [0.0, 0.0, None]}}
    scene["tractions"] = {"pull": {"body": "b", "face": "x-max", "traction": [0.3, 1.0, 0.0]}}
    thick = pgimp.Simulation(scene)
    thick.advance()
    here, there = flat.diagnostics(), thick.diagnostics()
    for axis in "xy":
        way = here[f"body.b.centre-{axis}"] - {"x": 2.0, "y": 1.5}[axis]
        wanted = there[f"body.b.centre-{axis}"] - {"x": 2.0, "y": 1.5}[axis]
        assert way == pytest.approx(wanted, rel=0.01)
    assert here["strain-energy"] == pytest.approx(there["strain-energy"] / 0.25, rel=0.01)
    assert abs(way) > 0.05


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"dimensions": 3}, "plane-stress is for 2 dimensions"),
        ({"method": {"volumetric": "b-bar"}}, "plane stress does not have"),
        ({"more": {"model": "newtonian"}}, "newtonian is not known in plane stress"),
        ({"start": {"stress": {"k0": 0.5}}, "gravity": [0.0, -1.0]}, "a part out of the plane"),
    ],
)
def test_what_plane_stress_does_not_know_is_refused(change, text):
    scene = case("neo-hookean", **change)
    if change.get("more"):
        scene["materials"]["m"] = {
            "model": "newtonian", "bulk": 100.0, "shear-viscosity": 1.0, "density": 1.0,
        }  # fmt: skip
    with pytest.raises(ValueError, match=text):
        Case.model_validate(scene)
