"""Functions of one's own: what is refused, with file and line; and what they give."""

import re
from math import sin, sqrt

import numpy as np
import pytest

import pgimp
from pgimp.errors import CaseError, RunError, UsageError
from pgimp.jit.kernel import kernel
from pgimp.physics.functions.registry import FUNCTIONS
from pgimp.physics.materials import registry

HERE = re.escape(__file__)


@pytest.fixture(autouse=True)
def registered():
    """Functions that a test registers are gone after it."""
    before = dict(FUNCTIONS)
    yield
    FUNCTIONS.clear()
    FUNCTIONS.update(before)


def case(**parts):
    """A block in 2D that touches nothing."""
    box = {"box": {"min": [1.0, 1.0], "max": [3.0, 3.0]}}
    return {
        "format": 1, "dimensions": 2, "grid": {"size": [4.0, 4.0], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles_per_cell": [2, 2]},
        "time": {"end": 0.1, "step": 0.01},
        "materials": {"m": {"model": "neo-hookean", "young": 100.0, "poisson": 0.3,
                            "density": 1.0}},
        "bodies": {"b": {"material": "m", "region": box}},
    } | parts  # fmt: skip


def refused(**parts):
    with pytest.raises(CaseError) as error:
        pgimp.load(case(**parts))
    return str(error.value)


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
    assert pgimp.load(case(body_force=entry)).model_dump(by_alias=True)["body_force"] == {
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
    with pytest.raises(CaseError, match=r"body_force.function: .*returns \(nan, 0\) at the part"):
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


def chosen(t, first):
    return (1.0, 2.0)[int(first + t * 1000.0)]


def half_plane(x):
    if x[0] > 2.0:
        raise ValueError("no such place")
    return 100.0


def test_exceptions_are_of_the_function():
    pgimp.coefficient(chosen)
    found = refused(gravity=[0.0, {"function": "chosen", "parameters": {"first": 1.0}}])
    assert re.search(r"the coefficient 'chosen' \(.*\) raises IndexError: tuple index", found)
    pgimp.coefficient(half_plane)
    material = case()["materials"]["m"] | {"young": {"function": "half-plane"}}
    with pytest.raises(CaseError, match=r"'half-plane' \(.*\) raises ValueError: no such place"):
        pgimp.Simulation(case(materials={"m": material}))


def table(x, t, until):
    if t > until:
        raise ValueError("the table ends here")
    return 1.0, 0.0


def solves(X, t):
    if t > 0.025:
        raise ValueError("no solution any more")
    return (0.0 * t, 0.0), (0.0, 0.0), (0.0, 0.0, 0.0, 0.0)


def spent(t):
    if t > 0.10001:
        raise ValueError("no load any more")
    return 1.0


@pytest.mark.parametrize("how", ["simulation", "run"])
def test_an_exception_in_a_run_is_told_with_function_line_and_time(how, tmp_path):
    pgimp.body_force(table)
    given = case(body_force={"function": "table", "parameters": {"until": 0.025}})
    line = table.__code__.co_firstlineno
    text = (
        rf"the body force 'table' \({HERE}:{line}\) raises ValueError: the table ends here in line "
        rf"{line + 2}; after step 3, at t = 0.03"
    )
    with pytest.raises(RunError, match=text):
        if how == "run":
            pgimp.run(given, output=tmp_path / "run", quiet=True)
        else:
            pgimp.Simulation(given).step(5)


def test_an_exception_in_the_history_or_of_a_time_is_told_too():
    pgimp.exact_solution(solves)
    sim = pgimp.Simulation(case(exact={"function": "solves"}))
    sim.step(3)
    with pytest.raises(RunError, match=r"'solves' .* no solution any more in line .*after step 3,"):
        sim.diagnostics()
    pgimp.coefficient(spent)
    sim = pgimp.Simulation(case(gravity=[0.0, {"function": "spent"}]))
    with pytest.raises(RunError, match=r"'spent' .*: no load any more in line \d+ at t = 0\.1"):
        sim.case.gravity.value(0.1001)
