"""Fluids and gases along paths: pressure, viscous stress, plug, internal energy, heat."""

import numpy as np
import pytest
from one_material import case_of
from strain_paths import along, entry_of, invariants, shears, stretches

import pgimp
from pgimp.errors import CaseError
from pgimp.physics.materials.parameters.outside import takes_vectors

WATER = {"model": "newtonian", "bulk": 2.0e3, "shear-viscosity": 0.3}
MUD = {"model": "bingham", "bulk": 1.0e4, "shear-viscosity": 0.3} | {
    "yield-stress": 1.0, "shear": 1.0e3,
}  # fmt: skip
GAS = {"model": "ideal-gas", "gamma": 1.4, "energy": 2.5}


@pytest.mark.parametrize("exponent", [1.0, 7.0, 2.5])
@pytest.mark.parametrize("tension", [False, True])
def test_pressure_is_taits_and_its_work_the_energy(exponent, tension):
    """The integral of p over the volume, by NumPy, on a fine path in and out of tension."""
    entry = {"model": "newtonian", "bulk": 2.0e3, "exponent": exponent, "tension": tension}
    F = stretches([-0.3, 0.0, 0.0], [0.02, 0.01, 0.0], [-0.1, 0.0, 0.1], steps=2000)
    found, J = along(entry, F), np.linalg.det(F)
    p = 2.0e3 / exponent * (J**-exponent - 1.0)
    if not tension:
        p = np.maximum(p, 0.0)
    np.testing.assert_allclose(found["stress"][:, :3], -p[:, None] * np.ones(3), 1e-10, 1e-10)
    assert not found["stress"][:, 3:].any()
    np.testing.assert_allclose(found["energy"], found["work"], 0, 2e-6 * found["energy"].max())


@pytest.mark.parametrize("D", [1, 2, 3])
def test_viscous_stress(D):
    """2 mu dev(D) of the step's velocity gradient, less where there are voids; and its work."""
    rng = np.random.default_rng(7)
    for size in (-0.1, 0.1):  # compressed, and expanded
        F = np.eye(D) * (1.0 + size) + 0.02 * rng.normal(size=(D, D))
        dt = 0.05
        found, J = along(WATER, F[None], dt), np.linalg.det(F)
        rate = np.zeros((3, 3))
        rate[:D, :D] = (F - np.eye(D)) / dt
        rate = (rate + rate.T) / 2
        s = 0.6 * min(1.0, 1.0 / J) * (rate - np.trace(rate) / 3 * np.eye(3))
        p = max(2.0e3 / 7 * (J**-7 - 1.0), 0.0)
        expected = (s - p * np.eye(3))[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
        expected[{1: 3, 2: 4, 3: 6}[D] :] = 0.0
        np.testing.assert_allclose(found["stress"][0], expected, 1e-10, 1e-10)
        assert found["lost"][0] == pytest.approx(J * dt * (s * rate).sum(), rel=1e-10)


@pytest.mark.parametrize("D", [2, 3])
def test_bingham_in_steady_shear(D):
    """Elastic up to the yield stress; then yield stress plus viscosity times rate."""
    rate, dt = 2.0, 2e-5
    found = along(MUD, shears(rate, dt, 1000, D), dt)
    _, tau = invariants(found["stress"])
    # The shear stress of Hencky's law is that of linear elasticity to second order of 1e-3.
    np.testing.assert_allclose(tau[:10], 1.0e3 * rate * dt * np.arange(1, 11), 1e-5)
    # It relaxes as exp(-t G/mu), by implicit steps.
    # Elastic strains of 1.6e-3 turn with the shear, which changes tau to second order.
    assert tau[-1] == pytest.approx(1.0 + 0.3 * rate, rel=1.6e-3**2)
    assert (np.diff(tau) > -1e-8).all()
    still = along(MUD, np.concatenate([shears(rate, dt, 1000, D), shears(0.0, dt, 1, D)]), dt)
    assert still["lost"][-1] >= found["lost"][-1]
    # What flow takes is the work less what is stored: of first order, as a step's end stress is.
    assert found["lost"][-1] == pytest.approx(found["work"][-1] - found["energy"][-1], rel=1e-3)


def test_the_plug_holds_for_ever():
    """Below the yield stress nothing creeps: to and fro, the stress comes back to rounding."""
    quarter = shears(4e-4, 1.0, 1)[0]
    path = np.concatenate([[quarter, np.eye(2)] for _ in range(500)])
    found = along(MUD, path, 1e3)  # long steps: nothing depends on time
    _, tau = invariants(found["stress"])
    assert tau[0] == pytest.approx(0.4, rel=1e-6)
    np.testing.assert_allclose(tau[::2], tau[0], 1e-12)
    assert (tau[1::2] < 1e-12).all() and (found["lost"] == 0.0).all()


@pytest.mark.parametrize("D", [1, 2, 3])
def test_an_adiabat_is_of_second_order(D):
    """p V^gamma stays, and the energy gains the work, with errors that fall by 4."""
    errors = []
    for steps in (50, 100):
        F = stretches([-0.5, 0.3, 0.0][:D], [0.4] + [0.0] * (D - 1), steps=steps)
        found, J = along(GAS, F), np.linalg.det(F)
        errors.append(np.abs(found["stress"][:, 0] + J**-1.4).max())
        assert (found["stress"][:, :3] == found["stress"][:, :1]).all()
        np.testing.assert_allclose(-found["stress"][:, 0] * J, 0.4 * found["internal-energy"])
        np.testing.assert_allclose(found["energy"], found["internal-energy"])
    assert errors[0] < 2e-3 and errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_viscosity_heats_the_gas_by_its_work():
    """A closed box of gas that is shaken: kinetic and internal energy together stay."""
    law = GAS | {"density": 1.0, "viscosity": {"linear": 0.5, "quadratic": 1.5}}
    case = {
        "format": 1,
        "dimensions": 1,
        "grid": {"size": [20.0], "cell": [1.0]},
        "method": {"shape": "finite-gimp", "particles-per-cell": [2]},
        "materials": {"gas": law},
        "bodies": {
            "left": {
                "material": "gas",
                "region": {"box": {"min": [0.0], "max": [10.0]}},
                "velocity": [1.0],
            },
            "right": {
                "material": "gas",
                "region": {"box": {"min": [10.0], "max": [20.0]}},
                "velocity": [-1.0],
            },
        },
        "boundaries": {"x-min": "slip", "x-max": "slip"},
    }
    gained = []
    for courant in (0.2, 0.1):
        case["time"] = {"end": 20.0, "step": {"courant": courant}}
        sim = pgimp.Simulation(case).core
        first = sim.diagnostics()
        assert first["strain-energy"] == pytest.approx(2.5 * 20.0)
        while not sim.finished:
            sim.advance()
        last = sim.diagnostics()
        lost = first["kinetic-energy"] - last["kinetic-energy"]
        assert lost > 0.5 * first["kinetic-energy"]  # the shocks turned it into heat
        gained.append((last["strain-energy"] - first["strain-energy"]) / lost)
    # Force times displacement is of first order in the step, as in every scene's balance.
    assert abs(gained[1] - 1.0) < 0.05
    assert abs(gained[1] - 1.0) < 0.7 * abs(gained[0] - 1.0)


@pytest.mark.parametrize("entry", [WATER, MUD, GAS], ids=lambda entry: entry["model"])
def test_four_at_once(entry):
    assert takes_vectors(entry_of(entry), 2)


WRONG = {
    "gamma": (GAS | {"gamma": 1.0}, "gamma", "must be above 1"),
    "energy": (GAS | {"energy": 0.0}, "energy", "must be above 0"),
    "exponent": (WATER | {"exponent": 0.5}, "exponent", "must be at least 1"),
    "soft": (MUD | {"yield-stress": 2.0e3}, "yield-stress", "a hundred times the"),
    "viscosity": (WATER | {"viscosity": 0.3}, "viscosity", "mapping"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_refused(name):
    entry, key, words = WRONG[name]
    with pytest.raises(CaseError, match=rf"materials\.law\.{key}.*{words}"):
        pgimp.load(case_of(entry))
