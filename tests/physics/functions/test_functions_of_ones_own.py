"""Functions of one's own: what is refused, with file and line; and what they give."""

import re
from math import sin, sqrt

import numpy as np
import pytest
from free_block import case, refused

import pgimp
from pgimp.errors import CaseError, RunError, UsageError
from pgimp.jit.kernel import kernel
from pgimp.physics.materials import registry

HERE = re.escape(__file__)


def star(x, *more):
    return x


def late(amplitude, t):
    return amplitude, 0.0


def speedy(x, v):
    return v


def texts(x, size="large"):
    return x


def hidden(x, _a):
    return x


WRONG = {
    star: "takes \\*more, but a velocity has arguments of fixed names alone: x",
    speedy: "a velocity is not given v, but x, t; take another name",
    texts: "the default of size must be a finite number or a tuple of them, not 'large'",
    hidden: "the parameter _a cannot be a key of a case",
}


@pytest.mark.parametrize("function", WRONG, ids=lambda function: function.__name__)
def test_wrong_arguments_are_refused_with_file_and_line(function):
    with pytest.raises(UsageError, match=f"^{HERE}:\\d+: {function.__name__}: {WRONG[function]}"):
        pgimp.velocity(function)


def test_what_is_no_plain_function_and_a_name_twice_are_refused(tmp_path):
    with pytest.raises(UsageError, match="t comes after parameters; first X, x, v, t, as far as"):
        pgimp.body_force(late)
    with pytest.raises(UsageError, match="a coefficient is a plain function, which pgimp compiles"):
        pgimp.coefficient(kernel(sqrt_of))
    with pytest.raises(UsageError, match="the name 'no name' cannot be one in a case"):
        pgimp.coefficient("no name")(sqrt_of)
    pgimp.coefficient("twice")(sqrt_of)
    pgimp.coefficient("twice")(sqrt_of)  # a cell of a notebook, run again
    text = f"other: there is a function 'twice' already, the coeff.*{HERE}:.*, @pgimp.stress"
    with pytest.raises(UsageError, match=text):
        pgimp.stress("twice")(other)
    text = "import pgimp\n\n\n@pgimp.velocity\ndef wrong(x, *args):\n    return x\n"
    (tmp_path / "own_wrong.py").write_text(text)
    with pytest.raises(UsageError, match=r"own_wrong.py:4: wrong: takes \*args"):
        registry.import_file(str(tmp_path / "own_wrong.py"))
    (tmp_path / "own_end.py").write_text(
        "import sys\n\nsys.exit(0)\n"
    )  # would end pgimp as if done
    with pytest.raises(UsageError, match=r"own_end.py: line 3: SystemExit: 0"):
        registry.import_file(str(tmp_path / "own_end.py"))


def sqrt_of(t):
    return sqrt(t)


def other(x):
    return x


def pull(x, t, strength, direction=(1.0, 0.0)):
    return strength * direction[0], strength * direction[1]


def test_a_case_names_what_is_unknown():
    pgimp.body_force(pull)
    pgimp.coefficient(sqrt_of)
    entry = {"function": "pull", "parameters": {"strength": 1.0}}
    assert pgimp.load(case(body_force=entry)).model_dump(by_alias=True)["body-force"] == {
        "function": "pull", "parameters": {"strength": 1.0, "direction": (1.0, 0.0)}
    }  # fmt: skip
    text = refused(body_force=entry | {"function": "pul"})
    assert "body_force.function: unknown body force 'pul'; did you mean 'pull'?" in text
    assert "--import FILE.py" in text
    text = refused(body_force=entry | {"function": "sqrt-of"})
    assert f"expected a body force, but this is the coefficient 'sqrt-of' ({__file__}:" in text
    text = refused(body_force={"function": "pull"})
    assert "body_force.parameters: missing; the body force 'pull' (" in text
    assert ") needs strength" in text
    entry["parameters"] = {"direction": [0.0, 1.0]}
    text = refused(body_force=entry)
    assert "body_force.parameters.strength: missing; the body force 'pull' (" in text
    entry["parameters"] = {"strength": 1.0}
    text = refused(body_force=entry | {"parameters": {"strengt": 1.0}})
    assert "body_force.parameters.strengt: unknown parameter 'strengt'" in text
    text = refused(body_force=entry | {"parameters": {"strength": "large"}})
    assert "body_force.parameters.strength: expected a number or a list of them" in text
    text = refused(body_force="function")
    assert "expected {function: .., parameters: {..}}" in text
    text = refused(gravity=[0.0, {"function": "pull"}])
    assert "expected a coefficient, but this is the body force 'pull'" in text
    young = {"function": "sqrt-of"}
    text = refused(materials={"m": case()["materials"]["m"] | {"young": young}})
    assert "takes t, which it is not given here: a parameter of a material is of x alone" in text


def short(x):
    return (1.0,)


def whole(x):
    return 1.0, 0


def unknown(x):
    return no_such_name  # noqa: F821


def pair(X, t):
    return (0.0, 0.0), (0.0, 0.0)


def flat(X, t):
    return (0.0, 0.0), (0.0, 0.0), (0.0, 0.0, 0.0)


def listed(t):
    return [t]


def test_functions_that_do_not_fit_are_refused_where_they_are_named():
    for function, text in {
        short: "must return the 2 components x y of a vector in 2D as a tuple, but returns a tuple "
        "of 1",
        whole: "must return floats, but the component y of a vector in 2D is an int; write 0.0",
        unknown: "does not compile: ",
    }.items():
        pgimp.velocity(function)
        bodies = {"b": case()["bodies"]["b"] | {"velocity": {"function": function.__name__}}}
        found = refused(bodies=bodies)
        where = f"bodies.b.velocity.function: the velocity '{function.__name__}' ({__file__}:"
        assert where in found and text in found
    for function, text in {
        pair: "must return three tuples, displacement, velocity and stress, but returns a tuple of "
        "2",
        flat: "must return the 4 components xx yy zz xy of the stress in 2D as a tuple",
    }.items():
        pgimp.exact_solution(function)
        assert text in refused(exact={"function": function.__name__})
    pgimp.coefficient(listed)
    assert "must return a float, but returns " in refused(gravity=[{"function": "listed"}, 0.0])


def root(t, until):
    return sqrt(until - t)


def hole(x):
    return (1.0 / (x[0] - 1.25), 0.0) if x[1] < 2.0 else (0.0, 0.0)


def test_what_is_no_number_is_refused():
    pgimp.coefficient(root)
    late = {"function": "root", "parameters": {"until": 0.05}}
    found = refused(gravity=[0.0, late])
    assert "gravity.1.function: the coefficient 'root' (" in found
    assert "returns nan at t = 0.0503906" in found
    pgimp.velocity(hole)
    bodies = {"b": case()["bodies"]["b"] | {"velocity": {"function": "hole"}}}
    with pytest.raises(CaseError, match=r"bodies.b.velocity: .* returns \(inf, 0\) at \(1.25, 1"):
        pgimp.Simulation(case(bodies=bodies))


def far(X, t):
    return (0.1 + t, 0.0 * X[0]), (1.0, 0.0), (0.0, 0.0, 0.0, 0.0)


def empty(x, t):
    return (0.0 if x[0] < 2.0 else sqrt(t - 1.0)), 0.0


def test_what_does_not_suit_the_particles_is_refused_as_they_are_made():
    pgimp.exact_solution(far)
    with pytest.raises(CaseError, match=r"exact.function: .* begins with a displacement of 0.1 at"):
        pgimp.Simulation(case(exact={"function": "far"}))
    pgimp.body_force(empty)
    with pytest.raises(CaseError, match=r"body-force.function: .*returns \(nan, 0\) at the part"):
        pgimp.Simulation(case(body_force={"function": "empty"}))


def ends(x, t, until):
    return sqrt(until - t), 0.0


def test_a_force_that_is_no_number_any_more_is_named():
    pgimp.body_force(ends)
    entry = {"function": "ends", "parameters": {"until": 0.025}}
    text = r"is not a finite number: the body force 'ends' \(.*:\d+\) returns \(nan, 0\) at .*0.03"
    sim = pgimp.Simulation(case(body_force=entry))
    with pytest.raises(RunError, match=text):
        sim.step(5)


def swing(t, rate):
    return 2.0 * rate * sin(rate * t)


def test_a_coefficient_of_time_has_its_integral():
    pgimp.coefficient(swing)
    entry = {"function": "swing", "parameters": {"rate": 30.0}}
    found = pgimp.load(case(gravity=[0.0, entry])).gravity
    for t in (0.0, 0.013, 0.1, 1.0, 7.0):
        assert found.value(t)[1] == 2.0 * 30.0 * sin(30.0 * t)
        assert found.integral(t)[1] == pytest.approx(2.0 * (1.0 - np.cos(30.0 * t)), abs=1e-12)


def test_an_integral_over_many_periods_is_resolved():
    """As the place of a table that shakes for minutes."""
    pgimp.coefficient(swing)
    entry = {"function": "swing", "parameters": {"rate": 300.0}}
    found = pgimp.load(case(gravity=[0.0, entry])).gravity.integral(10.013)[1]
    assert found == pytest.approx(2.0 * (1.0 - np.cos(3003.9)), abs=1e-5)


def test_a_parameter_spelled_twice_is_refused():
    pgimp.coefficient(two_words)
    values = {"the-rate": 1.0, "the_rate": 2.0}
    found = refused(gravity=[0.0, {"function": "two-words", "parameters": values}])
    assert "gravity.1.parameters.the_rate: is the-rate, which is given already" in found


def two_words(t, the_rate):
    return the_rate * t
