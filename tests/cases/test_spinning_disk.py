"""cases/own/spinning-disk.yaml: radial displacement and hoop's stress are those of a thin disk."""

from pathlib import Path

import numpy as np
import pytest

import pgimp
from pgimp.physics.materials import registry

CASES = Path(__file__).resolve().parents[2] / "cases"


@pytest.mark.wide
def test_a_disk_widens_as_it_is_spun_up(tmp_path):
    """Displacements to 2e-3; means of the stress over cells to 2e-3 of the greatest."""
    registry.import_file(str(CASES / "spin.py"))
    run = pgimp.run(CASES / "own/spinning-disk.yaml", output=tmp_path / "run", quiet=True)
    frame, a, b, nu = run.frame(-1), 0.25, 0.05, 0.3
    grown, stress = frame["displacement"][:, 0], frame["stress"]
    r = frame["position"][:, 0] - grown
    pull = (3.0 + nu) / 8.0 * 7850.0 * 500.0**2

    def hoop(r):
        ring = (a * b / r) ** 2
        return pull * (a * a + b * b + ring - (1.0 + 3.0 * nu) / (3.0 + nu) * r * r)

    def radial(r):
        return pull * (a * a + b * b - (a * b / r) ** 2 - r * r)

    assert hoop(np.array([b, a])) == pytest.approx([102.05e6, 25.5125e6])
    exact = r / 2.1e11 * (hoop(r) - nu * radial(r))
    assert np.abs(grown / exact - 1.0).max() < 2e-3  # across the thickness, of its mean
    cell = np.floor((r - b) / 0.005).astype(int)
    count = np.bincount(cell)
    middle, axial, found = (np.bincount(cell, each) / count for each in (r, *stress.T[1:3]))
    assert len(count) == 40 and np.abs(found - hoop(middle)).max() < 2e-3 * hoop(b)
    assert np.abs(axial).max() < 0.01 * hoop(b)  # free flats
