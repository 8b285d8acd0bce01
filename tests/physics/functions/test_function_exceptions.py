"""Exceptions of functions of one's own: told with function, file and line."""

import re

import pytest
from free_block import case, refused

import pgimp
from pgimp.errors import CaseError, RunError

HERE = re.escape(__file__)


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
