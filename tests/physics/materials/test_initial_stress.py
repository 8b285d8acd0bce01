"""Mohr and Coulomb's soil from the stress of a file: what it remembers, and what it becomes."""

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from meshes import case
from point_files import write_csv, write_hdf5
from reference_materials import tensor
from run_files import digests, go_back
from scenes import field, start, write_case
from tiers import wide

from pgimp.case.schema import Case
from pgimp.commands.check import report
from pgimp.jit.kernel import kernel
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.parameters.evaluate import evaluate
from pgimp.physics.materials.parameters.outside import parameters_of

pytestmark = pytest.mark.slow(50)

YOUNG, POISSON = 1.0e3, 0.3
SOIL = {
    "model": "mohr-coulomb", "young": YOUNG, "poisson": POISSON, "friction-angle": 30.0,
    "cohesion": 5.0, "density": 1.0,
}  # fmt: skip
#: Within the yield surface, whatever the order: 5 - 2 < (5 + 2)/2 + 2 * 5 cos(30 degrees).
STRESS = (-2.0, -5.0, -3.0)
COMPONENTS = {1: 3, 2: 4, 3: 6}
PAIRS = ("xx", "yy", "zz", "xy", "yz", "xz")


@kernel
def first_step(materials, F, sigma, L, state):
    """What a particle remembers of a stress, and stress and state after a step."""
    known = evaluate("initial_state", materials, 0, (F, 1.0, sigma), state)
    return known, evaluate("stress", materials, 0, (F, 1.0, sigma, L, 0.1), known)


def elastic(sigma, young=YOUNG):
    """b_e - 1 under a Kirchhoff stress (3, 3), by Hencky's law."""
    mean = np.trace(sigma) / 3
    shear, bulk = young / (2 * (1 + POISSON)), young / (3 * (1 - 2 * POISSON))
    strain = (sigma - mean * np.eye(3)) / (2 * shear) + mean / (3 * bulk) * np.eye(3)
    values, Q = np.linalg.eigh(strain)
    return Q @ np.diag(np.expm1(2 * values)) @ Q.T


@pytest.mark.parametrize("D", [1, 2, 3])
@settings(max_examples=100, deadline=None)
@given(data=st.data())
def test_a_step_that_strains_nothing_keeps_the_stress(D, data):
    """Whatever its size and orientation, with a soil so strong that it does not yield."""
    numbers = st.floats(-1.0, 1.0)
    parts = data.draw(arrays(float, COMPONENTS[D], elements=numbers))
    sigma = 10 ** data.draw(st.floats(-3.0, 2.5)) * parts
    strong = MATERIALS["mohr-coulomb"].model_validate(SOIL | {"cohesion": 1e4})
    parameters, F = parameters_of(strong, D), tuple(np.eye(D).ravel())
    state = (0.0,) * COMPONENTS[D] + (0.0, 0.25, 0.5)
    known, after = first_step((parameters,), F, tuple(sigma), (0.0,) * D**2, state)
    width = COMPONENTS[D]
    # Strains of 1 + b are rounded to 1e-16, and times the stiffness are stresses.
    np.testing.assert_allclose(after[:width], sigma, 1e-12, 1e-15 * YOUNG)
    assert known[width:] == (0.0, 0.25, 0.5)
    assert after[width:] == known
    np.testing.assert_allclose(tensor(known[:width]), elastic(tensor(sigma)), 1e-12, 2e-15)


def filled(per_cell=2, n=8, stress=STRESS, shear=0.0):
    """Particles that fill the domain on the lattice's points, with the same stress."""
    axis = -2.0 + (np.arange(n * per_cell) + 0.5) * 4.0 / (n * per_cell)
    x = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    rows = np.tile([*stress, shear, 0.0, 0.0], (len(x), 1))
    return {"position": x, "volume": np.full(len(x), (axis[1] - axis[0]) ** 2), "stress": rows}


def resting(path, **parts):
    """The case of particles between smooth walls."""
    found = case({"points": {"file": str(path)}}, dimension=2, step=0.004, **parts)
    found["materials"] = {"soft": SOIL}
    found["boundaries"] = {f"{axis}-{end}": "slip" for axis in "xy" for end in ("min", "max")}
    return found


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"formulation": "total-lagrangian"},
        *(wide(how) for how in ({"affine": True}, {"volumetric": "b-bar"}, {"shape": "cpdi"})),
    ],
    ids=lambda how: next(iter(how), "plain"),
)
def test_soil_under_pressure_between_walls_stays_as_it_is(tmp_path, how):
    """A uniform stress is in equilibrium there: nothing moves, whatever the method."""
    write_hdf5(tmp_path / "p.h5", filled())
    model = resting(tmp_path / "p.h5")
    target = model["bodies"]["body"] if "formulation" in how else model["method"]
    target |= how
    sim = start(model)
    for _ in range(20):
        sim.advance()
    np.testing.assert_allclose(field(sim, "sigma")[:, :3], np.tile(STRESS, (256, 1)), 1e-11)
    assert np.abs(field(sim, "v")).max() < 1e-12
    assert np.abs(field(sim, "state")[:, 4:]).max() < 1e-15
    assert sim.diagnostics()["plastic-work"] == pytest.approx(0.0, abs=1e-12)


def test_a_stress_beyond_the_strength_is_returned_as_that_of_the_cone(tmp_path):
    """In the first step, to where s_max - s_min = 2 c cos(30) - (s_max + s_min)/2."""
    write_hdf5(tmp_path / "p.h5", filled(stress=(-2.0, -40.0, -10.0)))
    found = []
    for name in ("mohr-coulomb", "drucker-prager"):
        model = resting(tmp_path / "p.h5")
        model["materials"] = {"soft": SOIL | {"model": name}}
        sim = start(model)
        sim.advance()
        found.append(field(sim, "sigma"))
        assert sim.diagnostics()["plastic-work"] > 0.1
    high, low = found[0][:, :3].max(axis=1), found[0][:, :3].min(axis=1)
    limit = 10.0 * np.cos(np.radians(30.0)) - 0.5 * (high + low)
    np.testing.assert_allclose(high - low, limit, 1e-9)
    assert (found[1][:, 1] > -39.0).all()


@pytest.mark.parametrize("name", ["mohr-coulomb", "drucker-prager"])
def test_a_stress_beyond_the_strength_is_said(tmp_path, capsys, name):
    """How many particles and by how much, at the start of a run and by ``check`` alike."""
    data = filled()
    data["stress"][:100, :3] = (-2.0, -40.0, -10.0)
    for share in (100, 0):
        data["stress"][share:, :3] = STRESS
        write_hdf5(tmp_path / "p.h5", data)
        model = resting(tmp_path / "p.h5")
        model["materials"] = {"soft": SOIL | {"model": name}}
        sim = start(model)
        found = [text for text in sim.warnings if "beyond the strength" in text]
        assert len(found) == bool(share)
        report(Case.model_validate(model))
        shown = capsys.readouterr().out
        assert ("beyond the strength" in shown) == bool(share)
        if share:
            sim.advance()
            lost = np.abs(field(sim, "sigma")[:, :3] - (-2.0, -40.0, -10.0)).max(axis=1).min()
            assert "100 of 256 particles" in found[0] and "'soft'" in found[0]
            by = float(found[0].split("up to ")[1].split(",")[0])
            assert by == pytest.approx(lost, rel=0.2)
            assert f"warning: {found[0]}" in shown


def test_parameters_that_vary_and_bodies_without(tmp_path):
    """Each particle by its own stiffness; another soil, and a soil of the lattice, beside it."""
    data = filled(shear=0.7)
    keep = data["position"][:, 0] < -0.5
    data = {name: values[keep] for name, values in data.items()}
    rng = np.random.default_rng(2)
    data["stiffness"] = rng.uniform(500.0, 2000.0, keep.sum())
    data["plastic-shear"] = rng.uniform(0.0, 1.0, keep.sum())
    write_hdf5(tmp_path / "p.h5", data)
    model = resting(tmp_path / "p.h5")
    cone = SOIL | {"model": "drucker-prager"}
    model["materials"] = {"soft": SOIL | {"young": {"column": "stiffness"}}, "other": cone}
    model["materials"]["lattice"] = SOIL
    for name, low, high, material in (("box", -0.5, 1.0, "lattice"), ("far", 1.0, 2.0, "other")):
        region = {"box": {"min": [low, -2.0], "max": [high, 2.0]}}
        model["bodies"][name] = {"region": region, "material": material}
    sim = start(model)
    state, body = field(sim, "state"), field(sim, "body")
    assert not state[body > 0].any()
    mine = state[body == 0]
    np.testing.assert_array_equal(mine[:, 5], data["plastic-shear"])
    for row, young in zip(mine, data["stiffness"], strict=True):
        expected = elastic(tensor([*STRESS, 0.7]), young)
        np.testing.assert_allclose(tensor(row[:4]), expected, 1e-12, 1e-15)


def test_same_bits_on_ranks_resumed_and_in_stages(tmp_path, mpirun, python):
    """With a stress that is not in equilibrium, and gravity from the second stage on."""
    data = filled()
    rng = np.random.default_rng(7)
    stress = data.pop("stress") + rng.normal(0.0, 0.5, (256, 6))
    columns = {f"stress-{pair}": stress[:, i] for i, pair in enumerate(PAIRS[:4])}
    write_csv(tmp_path / "p.csv", data, **columns)
    model = resting("p.csv", end=0.1)
    model["time"]["stages"] = [{"name": "weight", "end": 0.2, "gravity": [0.0, -5.0]}]
    model["checkpoint"] = {"every": {"steps": 5}, "keep": 50}
    model |= {key: {"every": 0.05} for key in ("output", "history")}
    model["output"]["fields"] = ["stress", "elastic-stretch"]
    write_case(tmp_path / "p.yaml", model)
    one = python(["-m", "pgimp", "p.yaml", "-o", "one"], cwd=tmp_path)
    assert one.returncode == 0, one.stderr
    three = mpirun(3, ["-m", "pgimp", "p.yaml", "-o", "three"], cwd=tmp_path)
    assert three.returncode == 0, three.stderr
    shutil.copytree(tmp_path / "three", tmp_path / "two")
    go_back(tmp_path / "two", 0.2)
    two = mpirun(2, ["-m", "pgimp", "p.yaml", "-o", "two", "--resume"], cwd=tmp_path)
    assert two.returncode == 0 and "resuming from" in two.stdout, two.stderr
    assert digests(tmp_path / "one") == digests(tmp_path / "three") == digests(tmp_path / "two")
    assert len(digests(tmp_path / "one")) > 4
