"""Rigid bodies that meet others by their surfaces: books of energy and momentum."""

import numpy as np
import pytest
from scenes import box, scene, start

pytestmark = pytest.mark.slow(60)

EXACT = {"configuration": "initial", "surface": "exact"}


def history(case):
    """Lines of all steps, with the start."""
    sim = start(case)
    lines = [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        lines.append(sim.diagnostics())
    return sim, {name: np.array([line[name] for line in lines]) for name in lines[0]}


@pytest.mark.parametrize("body", [EXACT, {"configuration": "initial"}])
@pytest.mark.parametrize(
    ("velocity", "friction"),
    [([0.0, -1.0], 0.0), ([2.0, 0.0], 0.4),
     ({"translation": [0.5, -0.7], "rotation": {"about": [5.3, 4.5], "rate": -1.0}}, 0.3)],
    ids=["falls", "slides", "spins"],
)  # fmt: skip
def test_friction_and_impacts_are_what_is_lost(body, velocity, friction):
    """Of a heavy box on an elastic base: heat and impact loss, up to second order in the step.

    Velocities are half a step behind positions: with energies of position taken half a step
    earlier, those of all columns add up to what there was, to rounding.
    """
    bodies = {
        "base": box([1.0, 0.0], [9.5, 3.0]) | body,
        "heavy": {"rigid": {"density": 8.0}, "velocity": velocity,
                  "region": {"box": {"min": [4.1, 3.4], "max": [6.5, 5.6]}}},
    }  # fmt: skip
    case = scene(2, bodies, cells=[11, 9], step=0.01, end=4.0,
                 gravity=[0.0, -1.0], boundaries={"y-min": "fixed"},
                 contact=[{"bodies": "all", "friction": friction}])  # fmt: skip
    sim, line = history(case)
    (heavy,) = sim.scene.interaction.rigid_bodies.free.values()
    kinetic, strain = line["tool.heavy.kinetic-energy"], line["strain-energy"]
    own = line["kinetic-energy"] + strain
    height = heavy.bulk.mass * (line["tool.heavy.displacement-y"] + 0.4)
    scale = np.max(kinetic + height)
    weight = line["external-work"] - line["tool.heavy.work"]
    whole = kinetic + own + line["dissipated-energy"] - weight + height
    whole = whole[1:] - 0.5 * np.diff(height)
    assert np.ptp(whole) < 1e-12 * scale
    heat, loss = line["contact.all.friction-heat"], line["contact.all.impact-loss"]
    rest = line["dissipated-energy"] - heat - loss
    rest += 0.5 * np.gradient(strain - weight)
    assert np.abs(rest).max() < 0.004 * scale
    assert loss[-1] > 0.01 * scale
