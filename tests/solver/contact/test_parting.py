"""A ball rests on a plate that is pulled away: nothing pulls it along."""

import numpy as np
import pytest
from scenes import SOFT, box, scene, start, tracked

pytestmark = pytest.mark.slow(30)


def resting(D, plate, **parts):
    """A ball of R = 2 on a plate, which its lowest point touches between two vertices."""
    middle = [4.3] * (D - 1)
    ball = {"material": "soft", "region": {"ball": {"centre": [*middle, 3.6], "radius": 2.0}}}
    return scene(D, {"ball": ball, "plate": plate}, cells=[9] * (D - 1) + [7], **parts)


def taken(sim, D):
    """Greatest momentum of the ball along each axis, and the last of the plate."""
    names = [f"body.{body}.momentum-{axis}" for body in ("ball", "plate") for axis in "xyz"[:D]]
    found = np.array(tracked(sim, *names))
    return np.abs(found[:D]).max(), np.abs(found[D:, -1])


@pytest.mark.parametrize("configuration", ["current", "initial"])
@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("D", [2, 3])
def test_a_plate_that_leaves_takes_nothing_along(D, friction, configuration):
    """Not a bit, whether it goes straight or aside."""
    plate = box([0.5] * (D - 1) + [0.6], [8.5] * (D - 1) + [1.6], [0.3, *[0.0] * (D - 2), -1.0])
    case = resting(D, plate, end=0.5, contact=[{"bodies": "all", "friction": friction}])
    for body in case["bodies"].values():
        body["formulation"] = configuration
    ball, own = taken(start(case), D)
    assert own[-1] == pytest.approx(8.0 ** (D - 1), rel=1e-9)
    assert ball == 0.0


def test_a_plate_that_is_tied_takes_the_ball_along():
    """They do touch."""
    plate = box([0.5, 0.6], [8.5, 1.6], [0.3, -1.0])
    case = resting(2, plate, end=0.5, contact=[{"bodies": "all", "law": "tie"}])
    ball, own = taken(start(case), 2)
    assert ball > 0.1 * own[-1]


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_ball_that_has_lain_on_a_plate_falls_freely(configuration):
    """Its weight has pressed it on a rigid plate, which then leaves at four times the fall."""
    velocity = {"table": [[0.0, [0.0, 0.0]], [3.0, [0.0, 0.0]], [3.6, [0.5, -2.4]]]}
    region = {"box": {"min": [-1.0, -1.0], "max": [10.0, 1.6]}}
    case = resting(
        2, {"rigid": {"velocity": velocity}, "region": region}, end=3.6, step={"courant": 0.3},
        gravity={"table": [[0.0, [0, 0]], [1.0, [0, -1]]]},
        contact=[{"bodies": "all", "friction": 0.5}], materials={"soft": SOFT | {"young": 400.0}},
    )  # fmt: skip
    case["bodies"]["ball"]["formulation"] = configuration
    time, force, along, momentum, mass = tracked(
        start(case), "time", "rigid.plate.force-y", "rigid.plate.force-x", "body.ball.momentum-y",
        "body.ball.mass",
    )  # fmt: skip
    weight, push = mass[0], -force
    assert push[(time > 1.5) & (time < 3.0)].mean() == pytest.approx(weight, rel=0.1)
    assert push.min() >= 0.0  # it is never held
    last = np.flatnonzero(push)[-1]
    assert 3.0 < time[last] < 3.3
    assert np.abs(along[last + 1 :]).max() == 0.0
    fall = momentum[last + 1 :] - momentum[last] + weight * (time[last + 1 :] - time[last])
    assert np.abs(fall).max() < 1e-12 * weight
