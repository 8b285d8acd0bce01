"""A bar that is pulled to three times its length holds with cpdi, whose boxes stay contiguous."""

from pathlib import Path

import numpy as np
import pytest

from pgimp.case.reader import read_case
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

CASE = Path(__file__).parents[2] / "cases" / "hard" / "stretch.yaml"


def pulled(shape, affine=False):
    """Stretch of the bar between its ends, and the force over what it should be, until the end."""
    changes = [f"method.shape={shape}", f"method.affine={str(affine).lower()}"]
    changes += ["time.step.courant=0.4"]
    case = read_case(CASE.read_text(encoding="utf-8"), CASE.name, changes)
    sim, lines = Simulation(case, Serial()), []
    while not sim.finished:
        sim.advance()
        if sim.step % 100 == 0:
            line = sim.diagnostics()
            lines.append((1.0 + 10.0 * line["time"] / 40.0, line["constraint.right-x"]))
    stretch, force = np.array(lines).T
    return stretch, force / (1.0e6 * (stretch - 1.0))


@pytest.mark.parametrize("affine", [False, True])
def test_cpdi_holds(affine):
    """Waves of the pull apart, a hundredth of it, the force is that of the stretch to the end."""
    stretch, part = pulled("cpdi", affine)
    late = stretch > 1.5
    assert np.abs(part[late] - 1.0).max() < 0.04
    assert part[stretch > 2.9].mean() == pytest.approx(1.0, abs=0.003)


def test_finite_gimp_tears():
    """At 1.7 times the length: particles move at the mean velocity of their boxes."""
    stretch, part = pulled("finite-gimp")
    assert np.abs(part[stretch > 1.9]).max() < 0.1
