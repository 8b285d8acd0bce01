"""The registry of warnings: what it lists is given, with its bounds, and nothing else is."""

import re
from pathlib import Path

import pytest

import pgimp
from pgimp.mpi.comm import Serial
from pgimp.running import forecast
from pgimp.scene.checks import rigid_motion as rigid
from pgimp.scene.checks import sanity
from pgimp.scene.checks.validity import low_waves
from pgimp.scene.checks.warned import WARNINGS
from pgimp.solver.simulation import Simulation

PACKAGE = Path(pgimp.__file__).parent


def test_each_kind_is_given_somewhere_and_no_other():
    given = set()
    for path in PACKAGE.rglob("*.py"):
        given.update(re.findall(r'warned\(\s*"([^"]+)"', path.read_text()))
    assert given == {*WARNINGS}


@pytest.mark.parametrize(
    ("id", "bound"),
    [
        ("load-strain", sanity._MOST_STRAIN),
        ("short-run", sanity._FEWEST_TRANSITS),
        ("few-cells", round(sanity._FEW)),
        ("short-step", sanity.LEAST_COURANT),
        ("fast-rigid", rigid._FAST),
        ("many-frames", forecast._MANY),
        ("low-wave", low_waves._LOW),
    ],
)
def test_the_bounds_are_those_of_the_checks(id, bound):
    assert f"{bound:,}" in WARNINGS[id].bound


def test_a_run_gives_those_of_its_start():
    """A floor that a block comes to, and a nearly incompressible one beside an absorbing face."""
    box = {"box": {"min": [2.0, 4.0], "max": [5.0, 6.0]}}
    case = pgimp.load({
        "format": 1, "dimensions": 2, "grid": {"size": [8.0, 8.0], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
        "time": {"end": 0.02, "step": 0.01}, "gravity": [0.0, -1.0],
        "materials": {"m": {"model": "neo-hookean", "young": 9.0, "poisson": 0.49, "density": 1.0}},
        "bodies": {"block": {"material": "m", "region": box}},
        "boundaries": {"y-min": "absorbing"},
    })  # fmt: skip
    said = Simulation(case, Serial()).warnings
    assert {text.id for text in said} >= {"locking", "absorbing-weight"}
    assert all(WARNINGS[text.id].stage == "start" for text in said)
