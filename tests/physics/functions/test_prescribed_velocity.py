"""Constraints that move by a function of one's own of place and time."""

import re
from math import cos, nan, sin

import numpy as np
import pytest
from scenes import box, field, finish, scene, start

import pgimp
from pgimp.case.schema import Case
from pgimp.errors import CaseError, RunError

pytestmark = pytest.mark.slow(40)

CENTRE = np.array([4.0, 4.0])


@pytest.fixture(scope="module", autouse=True)
def functions():
    @pgimp.velocity
    def spiral(x, t, rate, growth=0.0):
        """A rotation that gets faster, and grows."""
        a, b = x[0] - 4.0, x[1] - 4.0
        return growth * a - rate * (1.0 + t) * b, growth * b + rate * (1.0 + t) * a

    @pgimp.velocity
    def bending(x, t, most=0.3):
        """Not linear in space."""
        return most * sin(x[1] - 3.0) * cos(t), 0.1 * x[0] * t

    @pgimp.velocity
    def without_value(x, t):
        return nan, x[1]

    @pgimp.velocity
    def fails(x, t):
        if t > 0.1:
            raise ValueError("too late")
        return 0.0, 0.0

    @pgimp.velocity
    def of_place(x):
        return 0.0, 0.1 * x[0]


def grip(low, high, name, **parameters):
    """A part of the body that a function moves."""
    velocity = {"function": name, "parameters": parameters}
    return {"body": "body", "region": {"box": {"min": low, "max": high}}, "velocity": velocity}


def block(configuration, step=0.01, **grips):
    """A block of 4 x 2 whose ends are held by functions, or by `grips`."""
    ends = ([2.0, 3.0], [3.0, 5.0]), ([5.0, 3.0], [6.0, 5.0])
    every = {
        "left": grip(*ends[0], "spiral", rate=1.0, growth=0.1),
        "right": grip(*ends[1], "bending"),
    }
    body = box([2.0, 3.0], [6.0, 5.0]) | {"formulation": configuration}
    return scene(2, body, step=step, constraints=grips or every)


def bending(x, t):
    return np.stack([0.3 * np.sin(x[:, 1] - 3.0) * np.cos(t), 0.1 * x[:, 0] * t], axis=1)


def traced(velocity, x, end, steps):
    """Places at `end`, by the classical method of fourth order in small steps."""
    h = end / steps
    for n in range(steps):
        t = n * h
        a = velocity(x, t)
        b = velocity(x + 0.5 * h * a, t + 0.5 * h)
        c = velocity(x + 0.5 * h * b, t + 0.5 * h)
        d = velocity(x + h * c, t + h)
        x = x + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return x


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_held_particles_follow_the_function(configuration):
    """By the midpoint rule: a quarter of the error, or less, with half the step.

    In the initial configuration it is the vertices that follow it, and a particle is between them.
    """
    errors = []
    for step in (0.02, 0.01):
        sim = start(block(configuration, step))
        x, held = field(sim, "x"), field(sim, "constraint")[:, 0]
        finish(sim)
        now, angle, size = field(sim, "x"), 1.5, np.exp(0.1)
        turn = size * np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
        exact = CENTRE + (x[held == 1] - CENTRE) @ turn.T
        own = np.abs(now[held == 1] - exact).max()
        other = np.abs(now - traced(bending, x, 1.0, 100))[held == 2].max()
        errors.append((own, other))
    (a, b), (c, d) = errors
    assert c < 0.3 * a and c < 3e-4
    # Linear between vertices a cell apart: h^2/8 of the curvature, 0.3, over the time.
    assert d < (0.3 * b if configuration == "current" else 0.04)
    line = sim.diagnostics()
    assert "constraint.left-x" in line and "displacement.left-x" not in line


@pytest.mark.wide
def test_a_function_of_the_place_alone_and_others_besides():
    """A linear one moves exactly; beside it what turns, and what moves as before."""
    constraints = {
        "shear": grip([2.0, 3.0], [3.0, 5.0], "of-place"),
        "turn": {"body": "body", "region": {"box": {"min": [4.0, 3.0], "max": [4.5, 5.0]}},
                 "rotation": {"about": [4.0, 4.0], "rate": 1.0}},
        "pull": {"body": "body", "region": {"box": {"min": [5.5, 3.0], "max": [6.0, 5.0]}},
                 "velocity": [0.25, None]},
    }  # fmt: skip
    sim = start(block("current", 0.01, **constraints))
    x, held = field(sim, "x"), field(sim, "constraint")[:, 0]
    finish(sim)
    moved = field(sim, "x") - x
    np.testing.assert_allclose(moved[held == 1, 0], 0.0, atol=1e-14)
    np.testing.assert_allclose(moved[held == 1, 1], 0.1 * x[held == 1, 0], rtol=1e-12)
    np.testing.assert_allclose(moved[held == 3, 0], 0.25, rtol=1e-12)
    arm = x[held == 2] - CENTRE
    turn = np.array([[cos(1.0), -sin(1.0)], [sin(1.0), cos(1.0)]])
    np.testing.assert_allclose(moved[held == 2], arm @ turn.T - arm, atol=1e-12)


@pytest.mark.parametrize(
    ("parts", "problem"),
    [
        ({"rotation": {"about": [4.0, 4.0], "rate": 1.0}}, r"rotation\W+cannot be combined with a"),
        ({"force": [1.0, None]}, r"force\W+cannot be combined with a function"),
        ({"velocity": {"function": "spiral"}}, r"parameters\W+missing; .* needs rate"),
        ({"velocity": {"function": "spirall"}}, r"function\W+unknown velocity"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_refused(parts, problem):
    case = block("current", grip=grip([2.0, 3.0], [3.0, 5.0], "bending") | parts)
    with pytest.raises(ValueError) as told:
        Case.model_validate(case)
    assert re.search(r"constraints\.grip\.(velocity\.)?" + problem, str(told.value)), told.value


def test_functions_that_have_no_value_are_told():
    with pytest.raises(CaseError, match=r"constraints\.grip\.velocity: .*without-value.*nan"):
        start(block("current", grip=grip([2.0, 3.0], [3.0, 5.0], "without-value")))
    sim = start(block("current", grip=grip([2.0, 3.0], [3.0, 5.0], "fails")))
    with pytest.raises(RunError, match=r"too late.*after step 10"):
        finish(sim)


def test_an_initial_velocity_is_not_given_the_time():
    case = block("current")
    case["bodies"]["body"]["velocity"] = {"function": "bending"}
    with pytest.raises(ValueError, match="takes t, which it is not given here"):
        Case.model_validate(case)
