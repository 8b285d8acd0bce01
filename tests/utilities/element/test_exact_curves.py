"""Exact curves of soils, fluids and gases against textbook formulas, and updates against them."""

from math import exp, log, radians, sin, sqrt, tan

import numpy as np
import pytest
from strain_paths import entry_of

from pgimp.errors import UsageError
from pgimp.utilities.element.table import curve, errors, text

YOUNG, POISSON = 1.0e4, 0.3
G, K = YOUNG / (2 * (1 + POISSON)), YOUNG / (3 * (1 - 2 * POISSON))
CLAY = {
    "model": "cam-clay", "m": 1.2, "lambda": 0.2, "kappa": 0.04, "void-ratio": 1.0, "shear": 2.0e3,
    "preconsolidation": 100.0,
}  # fmt: skip
WATER = {"model": "newtonian", "bulk": 1.0e6, "shear-viscosity": 2.0, "density": 1000.0}
MUD = WATER | {"model": "bingham", "yield-stress": 50.0}
AIR = {"model": "ideal-gas", "density": 1.2, "gamma": 1.4, "energy": 2.0e5}
GRAINS = {
    "model": "mu-i", "young": 1.0e6, "poisson": 0.3, "mu-s": 0.38, "mu-2": 0.64, "i0": 0.279,
    "grain": 1.0e-3, "grain-density": 2500.0, "density": 1500.0,
}  # fmt: skip


def soil(model, cohesion=0.0, dilation=0.0, **more):
    angles = {"friction-angle": 30.0, "dilation-angle": dilation}
    entry = {"model": model, "young": YOUNG, "poisson": POISSON, "cohesion": cohesion}
    return entry | angles | more


def table(entry, path, to, steps=40, confine=0.0, rate=1.0):
    values = to if isinstance(to, list) else [to]
    return curve(entry_of(entry), path, values, steps, confine, rate)


SOILS = [
    soil("drucker-prager"), soil("drucker-prager", 20.0, 10.0),
    soil("drucker-prager", 20.0, 10.0, tension=5.0), soil("drucker-prager", match="compression"),
    soil("mohr-coulomb"), soil("mohr-coulomb", 20.0, 10.0),
    soil("mohr-coulomb", 20.0, 0.0, tension=5.0),
]  # fmt: skip


@pytest.mark.parametrize("steps", [7, 40])
@pytest.mark.parametrize("to", [-0.1, 0.1])
@pytest.mark.parametrize("path", ["triaxial", "oedometer", "undrained", "isotropic"])
@pytest.mark.parametrize("entry", SOILS, ids=range(len(SOILS)))
def test_soils_follow_their_curves(entry, path, to, steps):
    """Exactly, in any number of steps; strains across are found to 1e-13 of the stiffness."""
    found = table(entry, path, to, steps, confine=100.0)
    assert "exact-pressure" in found and "exact-stress-xx" in found
    assert max(errors(found).values()) < 1e-9
    stresses = ("pressure", "stress-xx", "q")
    assert max(errors(found)[name] for name in stresses if f"exact-{name}" in found) < 1e-10


@pytest.mark.parametrize("cohesion", [0.0, 20.0])
@pytest.mark.parametrize("confine", [50.0, 200.0])
def test_mohr_coulomb_fails_at_the_textbooks_stress(cohesion, confine):
    """s1 = s3 N + 2 c sqrt(N), N = tan^2(45 + phi/2), in compression; s3 = ... in extension."""
    N = tan(radians(45.0 + 15.0)) ** 2
    entry = soil("mohr-coulomb", cohesion)
    found = table(entry, "triaxial", -0.1, confine=confine)
    assert -found["exact-stress-xx"][-1] == pytest.approx(confine * N + 2 * cohesion * sqrt(N))
    assert -found["stress-yy"][-1] == pytest.approx(confine, rel=1e-10)
    found = table(entry, "triaxial", 0.1, confine=confine)
    expected = max((confine - 2 * cohesion * sqrt(N)) / N, -cohesion / tan(radians(30.0)))
    assert -found["exact-stress-xx"][-1] == pytest.approx(expected)


def test_a_cone_matched_to_compression_fails_as_mohr_coulomb():
    cone = table(soil("drucker-prager", 20.0, match="compression"), "triaxial", -0.1, confine=90.0)
    edge = table(soil("mohr-coulomb", 20.0), "triaxial", -0.1, confine=90.0)
    assert cone["exact-q"][-1] == pytest.approx(edge["exact-q"][-1], rel=1e-12)


def test_soil_is_as_stiff_as_hookes_law_first():
    """Young's modulus under constant stress across, K + 4/3 G without strain across."""
    for path, stiffness in (("triaxial", YOUNG), ("oedometer", K + 4 / 3 * G)):
        found = table(soil("mohr-coulomb", 20.0), path, -1e-5, 1, confine=1e-3)
        assert np.diff(found["exact-stress-xx"])[0] == pytest.approx(-1e-5 * stiffness, rel=1e-4)


def test_dilation_opens_the_soil_by_its_angle():
    """Plastic volume over plastic axial strain is 2 sin(psi)/(1 - sin(psi)) on the plateau."""
    found = table(soil("mohr-coulomb", 20.0, 10.0), "triaxial", -0.1, 100, confine=1.0)
    volume = np.diff(np.log(found["exact-det-F"]))[-1]
    s = sin(radians(10.0))
    assert volume / 1e-3 == pytest.approx(2 * s / (1 - s), rel=0.02)  # it swells: elastic strains


def test_pulled_apart_a_cone_ends_at_its_apex():
    found = table(soil("drucker-prager", 20.0), "oedometer", 0.1)
    assert -found["exact-pressure"][-1] == pytest.approx(20.0 / tan(radians(30.0)))
    assert found["exact-q"][-1] == pytest.approx(0.0, abs=1e-9) and found["exact-gap"][-1] > 0.0


def test_sand_is_sheared_under_pressure_only():
    sand = soil("drucker-prager")
    with pytest.raises(UsageError, match="--confine PRESSURE"):
        table(sand, "triaxial", -0.1)
    with pytest.raises(UsageError, match="--confine PRESSURE"):
        table(sand, "uniaxial-stress", -0.1)
    with pytest.raises(UsageError, match="--path triaxial"):
        table(sand, "uniaxial-stress", -0.1, confine=10.0)
    with pytest.raises(UsageError, match="begins under a pressure of 100"):
        table(CLAY, "uniaxial-stress", -0.1)
    found = table(sand, "triaxial", [-0.05, 0.05, -0.02], confine=10.0)
    assert np.abs(found["stress-yy"] + 10.0).max() < 1e-8
    assert np.isnan(found["exact-q"][42:]).all() and np.isfinite(found["exact-q"][:41]).all()
    assert "nan" not in text(found) and ",," in text(found)  # unknown rows are empty


@pytest.mark.parametrize("pressure", [100.0, 80.0, 15.0])
@pytest.mark.parametrize("confine", [0.0, 40.0, 150.0])
def test_clay_is_compressed_and_swells_on_its_lines(pressure, confine):
    """ln p by lambda on the way in, by kappa on the way out, of Kirchhoff's pressure J p."""
    found = table(CLAY | {"pressure": pressure}, "isotropic", [-0.3, -0.2, -0.4], 10, confine)
    assert max(errors(found).values()) < 1e-10
    p, volume = found["exact-pressure"] * found["det-F"], np.log(found["det-F"])
    slopes = np.diff(np.log(p)) / np.diff(volume)
    assert slopes[[9, 29]] == pytest.approx([-2.0 / 0.2] * 2, rel=1e-9)
    assert slopes[[10, 19, 20]] == pytest.approx([-2.0 / 0.04] * 3, rel=1e-9)
    assert found["pressure"][0] == pytest.approx(confine or pressure, rel=1e-10)


@pytest.mark.parametrize("pressure", [100.0, 80.0, 15.0])
def test_clay_sheared_at_constant_volume(pressure):
    """The curve solves the rate equations; the implicit step is first order in its length."""
    entry = CLAY | {"pressure": pressure}
    found = [table(entry, "undrained", -0.1, steps) for steps in (400, 800)]
    coarse, fine = (errors(each) for each in found)
    for name in ("pressure", "q", "preconsolidation", "plastic-compaction"):
        assert fine[name] < 0.6 * coarse[name] and fine[name] < 0.02
    p, q = found[1]["exact-pressure"], found[1]["exact-q"]
    end = table(entry, "undrained", -1.0, 4)
    assert end["exact-q"][-1] / end["exact-pressure"][-1] == pytest.approx(1.2, rel=1e-9)
    # dp = -v p/kappa de, d(shear) = dq/(3 G) + de 2 eta/(M^2 - eta^2), by the trapezoidal rule.
    flows = np.flatnonzero(np.abs(np.diff(p)) > 1e-7 * p[0])[1:60]
    eta = 0.5 * (q[flows] / p[flows] + q[flows + 1] / p[flows + 1])
    yielded = -np.log(p[flows + 1] / p[flows]) * 0.04 / 2.0
    shear = (q[flows + 1] - q[flows]) / (3 * 2.0e3) + yielded * 2 * eta / (1.44 - eta**2)
    np.testing.assert_allclose(shear, 0.1 / 800, rtol=2e-2)


def test_clay_at_its_critical_state_has_the_textbooks_strength():
    """q = M p_c/2 (2 p/p_c)^... of normally consolidated clay: p = p_c 2^-(1 - kappa/lambda)."""
    found = table(CLAY, "undrained", -2.0, 50)
    assert found["exact-pressure"][-1] == pytest.approx(100.0 * 2 ** -(1 - 0.2), rel=1e-9)
    assert found["exact-q"][-1] == pytest.approx(0.689219 * 100.0, rel=1e-5)


def test_liquids_are_compressed_by_taits_law():
    for entry, steps in ((WATER, 1), (WATER | {"tension": True}, 9), (MUD, 9)):
        for confine in (0.0, 1000.0):
            found = table(entry, "isotropic", [-0.1, 0.05], steps, confine)
            assert max(errors(found).values()) < 1e-10
    expected = 1.0e6 / 7 * (exp(0.7) - 1)
    assert table(WATER, "isotropic", -0.1)["exact-pressure"][-1] == pytest.approx(expected)


def test_newtons_fluid_is_sheared_by_its_rate():
    found = table(WATER, "simple-shear", [1.0, 0.5], 20, 1000.0, 10.0)
    assert max(errors(found).values()) < 1e-10
    assert found["exact-stress-xy"][[1, 20, 21]] == pytest.approx([20.0, 20.0, -20.0])
    for path in ("oedometer", "undrained"):  # its rate is that of a step's beginning: first order
        coarse, fine = (errors(table(WATER, path, -0.02, n, 0.0, 1e3))["q"] for n in (20, 40))
        assert fine < 0.6 * coarse and fine < 1e-3


@pytest.mark.parametrize("rate", [1.0, 20.0])
@pytest.mark.parametrize(("entry", "confine"), [(MUD, 0.0), (MUD | {"shear": 2e3}, 100.0)])
def test_binghams_fluid_in_shear(entry, confine, rate):
    """Elastic, then steady at yield stress + mu rate, less the square of tau/G."""
    to = 0.02 if "shear" not in entry else 6.0
    coarse, fine = (table(entry, "simple-shear", to, n, confine, rate) for n in (400, 800))
    G = entry.get("shear", 5.0e5)
    expected = 50.0 + 2.0 * rate
    off = 2 * (expected / G) ** 2 + 1e-9
    assert fine["exact-stress-xy"][-1] == pytest.approx(expected, rel=off)
    assert np.isnan(fine["exact-q"]).any() and np.isfinite(fine["exact-q"][:2]).all()
    assert errors(fine)["q"] < 1e-4
    assert errors(fine)["stress-xx"] < 0.6 * errors(coarse)["stress-xx"] + 1e-12


def test_gas_is_compressed_along_its_isentrope():
    """Second order in the step: the work is that of the mean pressure."""
    for path in ("isotropic", "oedometer"):
        coarse, fine = (errors(table(AIR, path, -0.5, n))["pressure"] for n in (20, 40))
        assert coarse / fine == pytest.approx(4.0, rel=0.05) and fine < 1e-4
    found = table(AIR, "isotropic", -0.5)
    assert found["exact-pressure"][-1] == pytest.approx(0.4 * 1.2 * 2.0e5 * exp(0.5 * 1.4))
    assert found["exact-internal-energy"][-1] == pytest.approx(2.0e5 * exp(0.5 * 0.4))


def test_grains_are_compressed_and_flow():
    found = table(GRAINS, "isotropic", [-0.02, 0.01], 10)
    bulk = 1.0e6 / (3 * (1 - 0.6))
    assert max(errors(found).values()) < 1e-10
    assert found["exact-pressure"][10] == pytest.approx(bulk * (exp(0.02) - 1), rel=1e-12)
    for rate in (0.1, 10.0, 1000.0):
        coarse, fine = (table(GRAINS, "simple-shear", 0.3, n, 1000.0, rate) for n in (600, 1200))
        inertia = rate * 1e-3 * sqrt(2500.0 / 1000.0)
        mu = 0.38 + 0.26 / (0.279 / inertia + 1.0)
        assert fine["exact-stress-xy"][-1] == pytest.approx(1000.0 * mu, rel=1e-5)
        assert errors(fine)["stress-xy"] < 1e-5
        assert errors(fine)["stress-xx"] < 0.6 * errors(coarse)["stress-xx"] + 1e-10


def test_the_volume_under_a_pressure():
    """-K ln J/J = p of soils, by the start of a confined path."""
    found = table(soil("mohr-coulomb"), "isotropic", -0.01, 1, 100.0)
    J = found["det-F"][0]
    assert -K * log(J) / J == pytest.approx(100.0, rel=1e-10)
