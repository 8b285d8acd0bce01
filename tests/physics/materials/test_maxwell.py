"""The material that docs/materials.md shows, which is updated from its stress."""

import re
from pathlib import Path

import numpy as np
import pytest
from material_driver import response
from scenes import scene

import pgimp
from pgimp.physics.materials import MATERIALS, registry
from pgimp.physics.materials.parameters.outside import parameters_of

pytestmark = pytest.mark.slow(30)

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "materials.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def maxwell(tmp_path_factory):
    """The material that docs/materials.md shows, as a file that is imported."""
    (text,) = re.findall(r'^```python\n("""Maxwell.*?)^```$', PAGE, re.MULTILINE | re.DOTALL)
    path = tmp_path_factory.mktemp("maxwell") / "maxwell.py"
    path.write_text(text)
    registry.import_file(str(path))
    yield {"model": "maxwell", "young": 100.0, "poisson": 0.3, "time": 0.05, "density": 1.0}
    del MATERIALS["maxwell"]


def test_an_initial_stress_relaxes_in_the_material_of_the_page(maxwell, tmp_path):
    """A bar at rest between two walls, from `points`: the deviator falls by 1/(1 + dt/T) a step."""
    x = np.arange(0.25, 8.0, 0.5)
    given = np.array([-3.0, 1.5, 6.0])
    names = ["x", "volume", *(f"stress-{part}" for part in ("xx", "yy", "zz"))]
    rows = [[place, 0.5, *given] for place in x]
    lines = [",".join(map(repr, row)) for row in np.array(rows).tolist()]
    (tmp_path / "bar.csv").write_text("\n".join([",".join(names), *lines, ""]))
    region = {"points": {"file": str(tmp_path / "bar.csv")}}
    case = scene(1, {"material": "soft", "region": region}, step=0.005, end=0.05)
    case |= {"materials": {"soft": maxwell}, "boundaries": {"x-min": "slip", "x-max": "slip"}}
    sim = pgimp.Simulation(case)
    assert sim.particles["stress"][:, :3] == pytest.approx(np.tile(given, (16, 1)))
    sim.advance()
    mean, kept = given.mean(), (1.0 + 0.005 / 0.05) ** -sim.steps
    assert sim.steps == 10
    found = sim.particles["stress"][:, :3]
    assert found == pytest.approx(np.tile(mean + kept * (given - mean), (16, 1)), rel=1e-12)


@pytest.mark.parametrize("D", [2, 3])
def test_the_stress_of_the_pages_material_turns_with_the_body(maxwell, D):
    """In a step of pure rotation it is Q S Q^T, with the rotation by Cayley's formula."""
    parameters = parameters_of(MATERIALS["maxwell"](**maxwell | {"time": 1e12}), D)
    rng = np.random.default_rng(5)
    W = rng.normal(size=(D, D))
    W -= W.T
    before = np.zeros((3, 3))
    before[:D, :D] = rng.normal(size=(D, D))
    before = before + before.T + np.diag([0.0, 0.0, 1.0])
    one = np.eye(D)
    Q = np.eye(3)
    Q[:D, :D] = np.linalg.solve(one - 0.05 * W, one + 0.05 * W)
    given = before[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]][: (3, 4, 6)[D - 1]]
    stress, energy, speed = response((parameters,), one, given, W, dt=0.1)
    assert stress == pytest.approx(Q @ before @ Q.T, rel=1e-9)
    lam, mu = parameters.lam, parameters.mu
    strain = (before - lam / (3 * lam + 2 * mu) * np.trace(before) * np.eye(3)) / (2 * mu)
    assert energy == pytest.approx(0.5 * np.sum(before * strain))
    assert speed == pytest.approx(np.sqrt(lam + 2 * mu))
