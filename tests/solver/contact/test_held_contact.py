"""Contact where constraints and walls hold the material: prescribed rigid bodies, free ones, tied.

What is held moves as it is told, whoever presses on it: it exchanges nothing with a rigid body that
moves as prescribed, and a free one stops on it.
"""

import numpy as np
import pytest
from scenes import box, energy, field, finish, scene, start

from pgimp.kernels.data.ledger import HEAT, LOSS

pytestmark = pytest.mark.slow(30)

#: Speeds up, slows down and goes back, along the surfaces and towards them.
WAY = {"table": [[0.0, [0.0, 0.0]], [0.2, [3.0, -0.2]], [0.6, [-2.0, 0.1]], [1.0, [0.0, 0.0]]]}

STICKY = {"normal": 2.0, "shear": 2.0, "reach": 0.3}
LAWS = {
    "without an entry": [],
    "tied": [{"bodies": "all", "law": "tie"}],
    "friction": [{"bodies": "all", "friction": 0.5}],
    "adhesion": [{"bodies": "all", "friction": 0.5, "adhesion": STICKY}],
}


def rigid(low, high, **motion):
    """A rigid body that fills a box."""
    return {"rigid": motion, "region": {"box": {"min": low, "max": high}}}


def held(law, density, grip):
    """A block that is gripped, one that a wall holds; on them rigid bodies that slide, and fall.

    The ball falls on the gripped block, from a twentieth of a cell.
    """
    bodies = {
        "gripped": box([2.0, 3.0], [6.0, 5.0]),
        "lies": box([8.0, 0.0], [12.0, 0.5]),
        "under": rigid([1.0, 1.0], [5.0, 3.0], velocity=WAY),
        "slides": rigid([8.5, 0.5], [11.5, 2.5], velocity=WAY),
        "falls": {
            "rigid": {"density": density},
            "velocity": [0.3, -1.0],
            "region": {"ball": {"centre": [4.1, 6.55], "radius": 1.5}},
        },
    }
    whole = {"box": {"min": [2.0, 3.0], "max": [6.0, 5.0]}}
    # Nothing comes near the upper wall; kernels are those of a floor that lets go.
    walls = {"y-min": "fixed", "y-max": "unilateral"}
    return scene(
        2, bodies, cells=[14, 10], end=1.0, boundaries=walls, contact=LAWS[law],
        constraints={"grip": {"body": "gripped", "region": whole, "velocity": grip}},
    )  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("density", [0.01, 1.0, 100.0])
def test_rigid_bodies_on_what_is_held(law, density):
    """No energy comes from nothing, however a tool slows down; a free body does not pass through.

    A tool and a gripped body, which both move as they are told, exchange nothing.
    """
    sim = start(held(law, density, [0.0, 0.0]))
    lines, spent = [sim.diagnostics()], [0.0]
    while not sim.finished:
        sim.advance()
        lines.append(sim.diagnostics())
        spent.append(sim.rank.ledger.contact[:, :, [HEAT, LOSS]].sum())
        assert lines[-1]["rigid.under.force-x"] == lines[-1]["rigid.under.force-y"] == 0.0
    every = {name: np.array([line[name] for line in lines]) for name in lines[0]}
    gained = energy(every) - energy(every)[0] - every["external-work"] + np.array(spent)
    assert gained.max() <= 1e-9 * energy(every).max()
    assert np.diff(spent).min() >= -1e-12
    assert every["rigid.under.work"][-1] == 0.0
    assert np.abs(every["rigid.slides.work"]).max() > 1.0
    # What the ball loses the grip takes.
    for axis in "xy":
        change = np.diff(every[f"rigid.falls.momentum-{axis}"])
        force = every[f"constraint.grip-{axis}"][1:]
        scale = 1e-12 * np.abs(every["rigid.falls.momentum-y"]).max()
        assert change == pytest.approx(force * np.diff(every["time"]), abs=scale)
    own, done = every["rigid.falls.kinetic-energy"], every["rigid.falls.work"]
    # Work is all that the ball gives up. Where it sticks its velocity is found less closely.
    off = 0.02 if law == "adhesion" else 1e-12
    assert np.abs(own - own[0] + done).max() <= off * own[0]
    # It comes down by a twentieth, and its surface is as round as a cell.
    assert every["rigid.falls.displacement-y"].min() > -0.2
    assert abs(every["rigid.falls.velocity-y"][-1]) < 0.1
    if "friction" not in law and law != "adhesion":
        assert np.abs([every[f"rigid.falls.velocity-{a}"][-1] for a in "xy"]).max() < 1e-6


def faster(case, times):
    """The same case in a unit of time that is `times` as long, so that all is as much faster."""
    table = [[t / times, [times * v for v in way]] for t, way in WAY["table"]]
    bodies = {name: dict(body) for name, body in case["bodies"].items()}
    for body in bodies.values():
        if "velocity" in body:
            body["velocity"] = [times * v for v in body["velocity"]]
        if "velocity" in body.get("rigid", {}):
            body["rigid"] = {"velocity": {"table": table}}
    soft = case["materials"]["soft"]
    time = {name: value / times for name, value in case["time"].items()}
    materials = {"soft": soft | {"young": times**2 * soft["young"]}}
    return case | {"bodies": bodies, "materials": materials, "time": time}


@pytest.mark.parametrize("walls", ["fixed", "unilateral"])
@pytest.mark.parametrize("times", [2.0**-20, 2.0**20])
def test_units_of_time_do_not_matter(walls, times):
    """Scaled by a power of two every number has the same digits, whatever is held, and how."""
    case = held("friction", 1.0, [0.0, 0.0])
    case["boundaries"]["y-min"] = walls
    one, other = finish(start(case)), finish(start(faster(case, times)))
    assert np.array_equal(field(one, "x"), field(other, "x"))
    assert np.array_equal(times * field(one, "v"), field(other, "v"))


def pushed(bodies, contact):
    """The left half of a block of 4 by 3 cells is gripped, and moved faster and faster."""
    half = {"box": {"min": [2.0, 1.0], "max": [4.0, 4.0]}}
    motion = {"table": [[0.0, 0.0], [1.5, 1.5], [2.0, 1.0]]}
    parts = {"grip": {"body": "a", "region": half, "velocity": [motion, None]}}
    return scene(2, bodies, cells=[12, 6], end=2.0, constraints=parts, contact=contact)


HALVES = {"a": box([2.0, 1.0], [4.0, 4.0]), "b": box([4.0, 1.0], [6.0, 4.0])}


def test_what_is_tied_to_a_gripped_body_moves_with_it():
    """As if both were one body, but for forces on what of one is too light to be accelerated."""
    sims = [
        finish(start(pushed({"a": box([2.0, 1.0], [6.0, 4.0])}, []))),
        finish(start(pushed(HALVES, [{"bodies": "all", "law": "tie"}]))),
    ]
    places = (field(start(sim.case), "x") for sim in sims)
    orders = [np.lexsort(np.round(x, 6).T) for x in places]
    first, second = (
        np.concatenate([field(sim, name)[order] for name in ("x", "v", "F", "sigma")], axis=1)
        for sim, order in zip(sims, orders, strict=True)
    )
    assert np.allclose(first, second, rtol=0.0, atol=1e-5)
    # The history names what the grip does, with what it drags.
    one, two = (sim.diagnostics() for sim in sims)
    assert two["external-work"] == pytest.approx(one["external-work"], rel=1e-7)


def test_what_a_grip_pushes_gets_its_acceleration():
    """A block before one that is gripped: after a time of loading it moves as fast."""
    sim = start(pushed(HALVES, [{"bodies": "all", "friction": 0.2}]))
    sim.diagnostics()
    while sim.time < 1.5 - 1e-9:
        sim.advance()
    line = sim.diagnostics()
    force = line["contact.all.normal-impulse"] / 1.5
    assert line["body.b.momentum-x"] / line["body.b.mass"] == pytest.approx(1.5, rel=0.02)
    assert force == pytest.approx(line["body.b.mass"], rel=0.02)
    assert line["constraint.grip-x"] == pytest.approx(line["mass"], rel=0.02)


@pytest.mark.parametrize("degrees", [0.05, 2.0, 20.0])
def test_a_slope_that_meets_what_is_held_across_it(degrees):
    """What may only move along x is driven by a steep enough slope; by a flat one not at all."""
    slope = np.radians(degrees)
    plane = {"half-space": {"point": [6.0, 3.0], "normal": [np.sin(slope), np.cos(slope)]}}
    region = {"intersection": [plane, {"box": {"min": [-5.0, -5.0], "max": [30.0, 30.0]}}]}
    upper = {"half-space": {"point": [6.0, 3.0], "normal": [-np.sin(slope), -np.cos(slope)]}}
    block = {"intersection": [upper, {"box": {"min": [4.0, 2.0], "max": [7.0, 6.0]}}]}
    bodies = {"block": {"material": "soft", "region": block},
              "slope": {"rigid": {"velocity": [0.0, 0.2]}, "region": region}}  # fmt: skip
    grip = {"body": "block", "region": {"box": {"min": [0.0, 0.0], "max": [12.0, 12.0]}},
            "velocity": [None, 0.0]}  # fmt: skip
    case = scene(2, bodies, end=0.1, step=0.01, constraints={"grip": grip},
                 contact=[{"bodies": "all", "friction": 0.1}])  # fmt: skip
    sim = start(case)
    mass, most = sim.diagnostics()["mass"], 0.0
    while not sim.finished:
        sim.advance()
        most = max(most, abs(sim.diagnostics()["rigid.slope.force-y"]))
    speed = sim.diagnostics()["momentum-x"] / mass
    if degrees < 6.0:  # the free part of the normal's square is below a hundredth
        assert most == speed == 0.0
    else:
        # The wedge would drive it at 0.2 / tan; the body yields, and begins it within the steps.
        assert 0.0 < speed < 0.4 / np.tan(slope)
        assert most * sim.time < 10.0 * mass * 0.2 / np.tan(slope) ** 2


def test_a_heavy_ball_comes_to_rest_on_what_is_held_across_alone():
    """The block may move along x, where the ball's normals hardly point; it does not sink in."""
    bodies = {"block": box([2.0, 2.0], [10.0, 4.0]),
              "ball": {"rigid": {"density": 20.0},
                       "region": {"ball": {"centre": [6.0, 6.0], "radius": 1.5}}}}  # fmt: skip
    grip = {"body": "block", "region": {"box": {"min": [0.0, 0.0], "max": [12.0, 12.0]}},
            "velocity": [None, 0.0]}  # fmt: skip
    case = scene(2, bodies, cells=[12, 12], end=3.0, step=0.01, gravity=[0.0, -1.0],
                 boundaries={"y-max": "unilateral"}, constraints={"grip": grip},
                 contact=[{"bodies": "all", "friction": 0.3}])  # fmt: skip
    line = finish(start(case)).diagnostics()
    # A thousandth of its own response is added, and of the weight of a step: 1e-5.
    assert abs(line["rigid.ball.velocity-y"]) < 1e-4
