"""What is booked of rigid bodies that move freely: energy, forces at vertices."""

import numpy as np
import pytest
from free_rigid import free, struck
from rank_scenes import meeting
from scenes import box, energy, finish, scene, start

from pgimp.kernels.data.ledger import IMPULSE
from pgimp.solver.state.grid_state import active_grid

pytestmark = pytest.mark.slow(30)


def test_forces_of_contact_at_vertices():
    """Those that a frame of the grid shows are what the next step books, free bodies included."""
    case = meeting()
    case["time"]["step"] = 0.01
    sim = start(case)
    for number in range(40):
        if number % 5 == 0:
            shown = active_grid(sim.rank, sim.time, 0.01).contact.sum(axis=0)
            before = sim.rank.ledger.contact[:, :, IMPULSE : IMPULSE + 3].sum(axis=(0, 1))
        sim.advance()
        if number % 5 == 0:
            after = sim.rank.ledger.contact[:, :, IMPULSE : IMPULSE + 3].sum(axis=(0, 1))
            scale = max(1.0, np.abs(shown).max())
            assert (after - before) / 0.01 == pytest.approx(shown, abs=1e-11 * scale)
    assert np.abs(shown).max() > 1.0


@pytest.mark.parametrize(
    ("law", "two"), [({}, False), ({"friction": 0.4}, False), ({"law": "tie"}, False),
                     ({}, True), ({"friction": 0.4}, True)],
)  # fmt: skip
@pytest.mark.parametrize("density", [0.05, 20.0])
@pytest.mark.parametrize("lagrangian", [(), ("block",), ("block", "next")])
def test_the_energy_of_the_whole_is_the_sum_of_its_columns(lagrangian, density, law, two):
    """Whatever a body loses at once as it hits is in impact-loss, and in what is dissipated.

    In 2D its moment of inertia is constant, and the sum is exact: to rounding.
    """
    bodies = {"block": box([1.0, 1.0], [4.0 if lagrangian else 7.0, 4.0]),
              "ball": {"rigid": {"density": density}, "velocity": [1.0, -2.0],
                       "region": {"ball": {"centre": [3.0, 5.6], "radius": 1.5}}}}  # fmt: skip
    if lagrangian:
        bodies["next"] = box([4.0, 1.0], [7.0, 4.0])
    if two:
        bodies["other"] = {"rigid": {"density": 3.0, "fixed": ["x", "rotation"]},
                           "velocity": [0.0, -1.0],
                           "region": {"box": {"min": [5.0, 4.1], "max": [6.8, 6.0]}}}  # fmt: skip
    case = scene(2, bodies, cells=[10, 9], end=0.6, step={"courant": 0.3},
                 contact=[{"bodies": list(bodies), **law}])  # fmt: skip
    for name in lagrangian:
        bodies[name]["formulation"] = "total-lagrangian"
    sim, rigid_bodies = start(case), [name for name in bodies if name not in ("block", "next")]
    sums, works, losses = [], [], []
    while not sim.finished:
        line = sim.diagnostics()
        kinetic = sum(line[f"rigid.{name}.kinetic-energy"] for name in rigid_bodies)
        sums.append(energy(line) + line["dissipated-energy"] + kinetic)
        works.append(sum(line[f"rigid.{name}.work"] for name in rigid_bodies))
        name = "contact." + "+".join(bodies)
        losses.append([line[f"{name}.impact-loss"], line["dissipated-energy"]])
        assert line["external-work"] == pytest.approx(works[-1], abs=1e-12 * sums[0])
        sim.advance()
    assert works[-1] > 0.05 * sums[0]
    assert np.abs(np.array(sums) / sums[0] - 1.0).max() < 1e-12
    assert losses[-1][0] > 0.0 and losses[-1][1] > 0.0


@pytest.mark.wide
def test_energy_of_a_body_in_3d_that_turns_while_it_is_in_touch():
    """What it gives up is booked, also where its axis turns: to 1e-4 of its energy."""
    case = struck(3, {"friction": 0.3}, 1.0)
    case["bodies"]["ball"] = free([0.7, 2.3, 1.4], [3.7, 3.9, 6.4], 1.0) | {
        "velocity": {
            "rotation": {"about": [2.2, 3.1, 3.9], "rate": [0.9, 0.5, -0.7]},
            "translation": [1.2, 0.3, -0.2],
        }
    }
    sim = start(case)
    every = []
    for _ in range(2):
        line = sim.diagnostics()
        own = line["rigid.ball.kinetic-energy"]
        every.append(own + line["rigid.ball.work"])
        finish(sim)
    assert line["contact.block+ball.normal-impulse"] > 1.0
    assert every[1] == pytest.approx(every[0], rel=1e-4)


@pytest.mark.parametrize("later", [False, True])
def test_a_body_force_does_not_act_on_free_bodies_and_it_is_said(later):
    """Also where a stage has it."""
    force = {"body-force": {"rotating-frame": {"about": [8.0, 4.0], "rate": 1.0}}}
    case = struck(2, {}, 1.0)
    assert not [text for text in start(case).warnings if text.startswith("body-force")]
    if later:
        case["time"]["stages"] = [{"name": "turn", "end": 3.0, **force}]
    else:
        case |= force
    assert [text for text in start(case).warnings if "on 'ball'" in text]
