"""Types of the public interface, as mypy --strict finds them in a script of a user."""

import sys
from pathlib import Path

from processes import run

#: mypy's memory of what has not changed; another one than that of the package's own options.
CACHE = Path(__file__).resolve().parents[1] / ".mypy_cache" / "strict"
SCRIPT = """
from typing import Any, assert_type

import numpy as np

import pgimp
from pgimp.case.schema import Case
from pgimp.io.results.frame import Frame
from pgimp.io.results.reader import Run
from pgimp.io.results.tables import Table

Array = np.ndarray[tuple[Any, ...], np.dtype[Any]]

case = pgimp.load("case.yaml")
assert_type(case, Case)
run = pgimp.run(case, overrides={"time.end": 1.0}, quiet=True)
assert_type(run, Run)
assert_type(pgimp.open("case.out"), Run)
assert_type(run.frame(-1), Frame)
assert_type(run.frame(-1)["velocity"], Array)
assert_type(run.history, Table)
simulation = pgimp.Simulation(case)
simulation.advance(to=0.5)
assert_type(simulation.time, float)
assert_type(pgimp.element({}, np.eye(3)), dict[str, Array])
try:
    simulation.step()
except pgimp.RunError as error:
    assert_type(error, pgimp.RunError)
simulation.step("once")
"""


def test_a_script_with_strict_types(tmp_path):
    """All names have types; a wrong argument, on the last line, is the only error."""
    (tmp_path / "script.py").write_text(SCRIPT)
    words = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", f"--cache-dir={CACHE}"]
    done = run([*words, "script.py"], cwd=tmp_path)
    last = SCRIPT.count("\n")
    assert done.stdout.splitlines() == [
        f'script.py:{last}: error: Argument 1 to "step" of "Simulation" has incompatible type '
        '"str"; expected "int"  [arg-type]'
    ], done.stdout + done.stderr
