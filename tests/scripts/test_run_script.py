"""scripts/run on machines of stand-ins, and what a wheel of the package has."""

import tomllib

import pytest
from machines import ROOT
from setuptools import find_packages

pytestmark = pytest.mark.slow(30)


def test_run_starts_two_ranks_or_as_many_as_asked(ready):
    pgimp = ready.root / ".venv/bin/pgimp"
    assert ready.run("scripts/run", "a case.yaml", "--set", "time.end=1").returncode == 0
    started = ready.called.splitlines()[-1]
    assert started.startswith("mpirun -n 2 ")
    assert started.endswith(f"{pgimp} a case.yaml --set time.end=1")
    ready.run("scripts/run", "-n", "5", "case.yaml")
    assert ready.called.splitlines()[-1].startswith("mpirun -n 5 ")


@pytest.mark.parametrize("words", [[], ["-n", "2"], ["a.yaml", "-n"], ["a.yaml", "-n", "0"]])
def test_run_explains_itself(ready, words):
    done = ready.run("scripts/run", *words)
    assert done.returncode == 2
    assert "scripts/run CASE.yaml [-n RANKS]" in done.stderr
    assert "mpirun" not in ready.called


def test_run_passes_the_status_on_and_explains_a_killed_rank(ready):
    done = ready.run("scripts/run", "case.yaml", STATUS="137")
    assert done.returncode == 137
    assert "signal 9, as happens when memory runs out" in done.stderr
    assert ready.run("scripts/run", "case.yaml", STATUS="75").returncode == 75


def test_wheel_has_every_module():
    """A folder without ``__init__.py`` works where pgimp is developed and is missing in a wheel."""
    configuration = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    packages = find_packages(str(ROOT), include=configuration["packages"]["find"]["include"])
    folders = {path.parent.relative_to(ROOT) for path in (ROOT / "pgimp").rglob("*.py")}
    assert {".".join(folder.parts) for folder in folders} == set(packages)


def test_wheel_has_every_other_file():
    configuration = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    files = [path for path in (ROOT / "pgimp").rglob("*") if path.is_file()]
    files += [path for path in (ROOT / "cases").rglob("*") if path.suffix in (".yaml", ".obj")]
    for path in files:
        if "__pycache__" not in path.parts and path.suffix != ".py":
            assert any(path.match(one) for one in configuration["package-data"]["*"]), path
