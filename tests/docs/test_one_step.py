"""docs/one-step-by-hand.md keeps its word: the solver's bits, what it prints, what it changes."""

import contextlib
import io
import re

import numpy as np
import pytest
from pages import FENCE, PAGES, ROOT

import pgimp
from pgimp.solver.decomposition import RESORT

SCRIPT = (ROOT / "cases" / "one_step.py").read_text(encoding="utf-8")
PAGE = PAGES["docs/one-step-by-hand.md"]
COLUMNS = ("x", "v", "F", "sigma")


def executed(text):
    """Names of the script after some of its cells, and the lines that it has printed."""
    names, said = {}, io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(text, "one_step.py", "exec"), names)
    return names, said.getvalue().splitlines()


@pytest.fixture(scope="module")
def whole():
    """After all of the script."""
    return executed(SCRIPT)


def columns(simulation):
    """Columns of the particles by their numbers."""
    p = simulation.core.particles
    rows = np.argsort(p.id)
    return {name: getattr(p, name)[rows] for name in COLUMNS}


def assert_same_bits(one, other):
    for name in COLUMNS:
        np.testing.assert_array_equal(columns(one)[name], columns(other)[name], name)


def test_the_script_is_short_and_its_cells_are_printed_as_they_are():
    assert len(SCRIPT.splitlines()) <= 80
    _, case, *cells = SCRIPT.split("# %% ")
    printed = [block for language, block in FENCE.findall(PAGE) if language == "python"]
    assert printed == [f"# %% {cell.rstrip()}\n" for cell in cells]
    assert len(cells) == 6 and "CASE = {" in case


def test_steps_by_hand_have_the_bits_of_the_solver():
    """One step, and two hundred, in which particles change their layers and rows are sorted."""
    script, _ = executed(SCRIPT.partition("# %% A change")[0])
    hand, p = script["hand"], script["p"]
    solver = pgimp.Simulation(script["CASE"])
    start = columns(solver)
    solver.step()
    for name, before in start.items():
        assert not np.array_equal(columns(hand)[name], before), name
    assert_same_bits(hand, solver)
    changes = 0
    for number in range(2, 201):
        layer = p.layer.copy()
        script["p2g"]()
        field, ledger = script["grid"].field, script["ledger"]
        arguments = script["domain"].frame, field, script["faces"], script["forcing"], ledger
        script["update_momentum"](*arguments, (), script["WHOLE"])
        script["g2p"]()
        changes += int((p.layer != layer).sum())
        if number % RESORT == 0:
            script["population"].sort()
    solver.step(199)
    assert changes > 100 and abs(columns(solver)["sigma"]).max() > 1e4
    assert_same_bits(hand, solver)


def test_the_page_says_what_the_script_prints(whole):
    _, said = whole
    words = " ".join(PAGE.split())
    assert len(said) == 6
    for line in said:
        assert f"`{line}`" in words, line
    equal, fields = re.search(r"(\d+) of (\d+) fields", words).groups()
    assert equal == fields


def test_the_change_is_the_relaxation_of_the_method(whole):
    """From the second step on, with the rate that the page names."""
    script, _ = whole
    case, rate = script["CASE"], float(re.search(r"`pic-damping: (\d+)`", PAGE)[1])
    assert rate * script["DT"] == pytest.approx(0.05)
    blend = {"name": "blend", "end": 1.0, "method": {"pic-damping": rate}}
    time = {"end": script["DT"], "step": script["DT"], "stages": [blend]}
    solver = pgimp.Simulation(case | {"time": time})
    solver.step(2000)
    assert solver.finished
    by_hand, expected = columns(script["hand"]), columns(solver)
    for name in COLUMNS:
        most = abs(expected[name]).max()
        np.testing.assert_allclose(by_hand[name], expected[name], rtol=0.0, atol=1e-9 * most)
    assert not np.allclose(by_hand["v"], columns(script["solver"])["v"], rtol=0.0, atol=1e-2)
