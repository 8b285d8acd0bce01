"""Rigid bodies that move freely under forces, springs and dashpots, against exact motions."""

from math import exp, sqrt

import pytest
from free_rigid import free
from scenes import box, scene, start

from pgimp.case.schema import Case


def hammer(**more):
    """A rigid body of mass 4 that does not meet the bar."""
    case = scene(
        1, {"bar": box([0.0], [3.0]), "ball": free([8.0], [10.0], 2.0, [0.0], **more)},
        cells=[16], end=1.0, boundaries={"x-min": "fixed"}, contact=[{"bodies": "all"}],
    )  # fmt: skip
    return case


def test_force_and_spring_swing_a_body():
    force = {"table": [[0.0, [0.0]], [0.2, [8.0]], [2.0, [8.0]]]}
    for stiffness, to in ((100.0, None), (1e7, [8.999])):
        spring = {"stiffness": stiffness} | ({"to": to} if to else {})
        sim = start(hammer(force=force, spring=spring))
        w, x, v = sqrt(stiffness / 4.0), 0.0 if to is None else 0.001, 0.0
        while not sim.finished:
            sim.advance()
            line = sim.diagnostics()
            if to:  # a spring that the steps do not resolve swings, and does no more
                assert abs(line["rigid.ball.displacement-x"]) < 0.01
                continue
            for _ in range(100):
                pull = 8.0 * min(sim.time / 0.2, 1.0)
                v += 1e-4 * (pull / 4.0 - w * w * x)
                x += 1e-4 * v
            assert line["rigid.ball.displacement-x"] == pytest.approx(x, abs=0.004)
    assert x == 0.001


def test_a_dashpot_slows_a_body():
    case = hammer(spring={"stiffness": 0.0, "dashpot": 8.0})
    case["bodies"]["ball"]["velocity"] = [1.0]
    sim = start(case)
    while not sim.finished:
        sim.advance()
    v = sim.diagnostics()["rigid.ball.velocity-x"]
    assert v == pytest.approx(exp(-2.0), rel=1e-3)


def test_wrong_entries_are_named():
    for entry, words in (
        ({"force": [1.0, 2.0]}, "bodies.ball.rigid.force"),
        ({"spring": {"stiffness": 1.0, "to": [1.0, 2.0]}}, "spring.to"),
        ({"spring": {"dashpot": 1.0}}, "stiffness"),
    ):
        with pytest.raises(Exception, match=words):
            Case.model_validate(hammer(**entry))
