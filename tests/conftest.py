"""Helpers for every test: processes on several ranks or on one, in an environment of their own."""

import gc
import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol
from unittest.mock import patch

import pytest
from costs import Costs
from hypothesis import settings
from processes import clean_env, interruptible, run

from pgimp.physics.functions.registry import FUNCTIONS

# The same examples in every run, so that a change is not refused for what it did not touch; others
# are looked for with --hypothesis-profile=default.
settings.register_profile("same", derandomize=True)
settings.load_profile("same")

#: Parameters that choose kernels. Of a test over several lists, one of them of these, each value of
#: each list is in some test that always runs, and all combinations with --all.
VARIANTS = {"D", "dimension", "dimensions", "shape", "configuration", "name", "model", "law",
            "transfer", "method", "damping", "material", "walls", "face", "floor"}  # fmt: skip
#: Those of which each value is in some test of a file, and not in each.
ANYWHERE = {"D", "dimension", "dimensions", "shape", "configuration"}
#: Values whose kernels many tests have.
USUAL = {2, "gimp", "current"}

#: Fixtures of what is started, as is in no test of the fast tier.
STARTED = {"display", "mpirun", "pvpython"}


def pytest_addoption(parser):
    """Add the options of the tiers."""
    group = parser.getgroup("pgimp")
    words = "leave out what starts ranks, Slurm or ParaView, and the files that take long"
    group.addoption("--fast", action="store_true", help=words)
    words = "also wide tests, and all combinations of dimensions, shapes and configurations"
    group.addoption("--all", action="store_true", help=words)
    words = "append what tests cost to a table: CPU seconds, those of compiling, kernels, test"
    group.addoption("--costs", metavar="FILE", help=words)


def pytest_configure(config):
    """List what files of tests cost, at the end; tests of Ctrl-C run in the background, too."""
    interruptible()
    table = None if hasattr(config, "workerinput") else config.option.costs
    config.pluginmanager.register(Costs(config.cache, table), "costs")


def pytest_ignore_collect(collection_path, config):
    """Do not even import slow files in the fast tier: three workers would."""
    if config.option.fast and collection_path.suffix == ".py":
        return "pytestmark = pytest.mark.slow" in collection_path.read_text() or None
    return None


def seconds(item):
    """CPU seconds that a test's file takes, by its mark `slow`; 0 without one."""
    mark = item.get_closest_marker("slow")
    return mark.args[0] if mark else 0


def choices(item):
    """Values of a test that have to be in some test, with the test's name unless any test will do.

    None of a test all of whose values are needed.
    """
    test, found = item.nodeid.partition("[")[0], set()
    marks = [mark.args[0] for mark in item.iter_markers("parametrize")]
    lists = [names.replace(" ", "").split(",") if isinstance(names, str) else list(names)
             for names in marks]  # fmt: skip
    several = len(lists) > 1 and VARIANTS & {name for names in lists for name in names}
    for names in lists:
        anywhere = len(names) == 1 and names[0] in ANYWHERE
        if not anywhere and not several:
            return set()
        values = [item.callspec.params[name] for name in names]
        found.add((*names, repr(values)) if anywhere else (test, *names, repr(values)))
    return found and found | {test}


def beyond_each_choice(items):
    """Of each file's tests over variants, those whose values are all in others' that stay.

    Every value stays in some test, and every test with some values: first those that few have
    together, then such as have been chosen before, so that kernels are shared.
    """
    files: dict[str, dict] = {}
    for item in items:
        if found := choices(item):
            files.setdefault(item.nodeid.partition("::")[0], {})[item] = found
    for values in files.values():
        missing, used, together = set().union(*values.values()), Counter(), set()
        while missing:

            def worth(item):
                params = item.callspec.params.values()
                return (
                    len(values[item] & missing),
                    kind(item) in together,
                    sum(isinstance(value, int | str) and value in USUAL for value in params),
                    -sum(used[value] for value in values[item]),
                )

            chosen = max(values, key=worth)
            together.add(kind(chosen))
            found = values.pop(chosen)
            missing -= found
            used.update(found)
        yield from values


def kind(item):
    """The variants of a test, whatever it tests."""
    params = item.callspec.params
    return tuple((name, repr(params[name])) for name in sorted(VARIANTS & {*params}))


def pytest_collection_modifyitems(config, items):
    """Begin with files that take long, so that no worker is left with one at the end.

    scripts/test hands out files in this order. Those that mostly wait, for Slurm, signals and what
    was killed, have numbers between those that keep a core busy: of three at a time one waits.
    """
    items.sort(key=seconds, reverse=True)
    left_out = []
    if not config.option.all:
        left_out += [item for item in items if item.get_closest_marker("wide")]
        left_out += beyond_each_choice(
            [item for item in items if not item.get_closest_marker("wide")]
        )
    if config.option.fast:
        left_out += [item for item in items if seconds(item) or STARTED & {*item.fixturenames}]
    if left_out:
        chosen = set(items) - set(left_out)
        config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
        items[:] = [item for item in items if item in chosen]


def pytest_collection_finish():
    """Spare all that is imported by now from garbage collection, half of whose time it takes."""
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def without_rehearsal():
    """Runs in the process of the tests begin without the rehearsal that compiles all kernels.

    What a test calls is compiled then, which is less. Runs in processes of their own have it.
    """
    with patch("pgimp.solver.setup.warm_up"), patch("pgimp.solver.stages.warm_up"):
        yield


@pytest.fixture(scope="module", autouse=True)
def functions_of_a_module():
    """Functions of one's own that a file of tests registers are gone after it."""
    before = dict(FUNCTIONS)
    yield
    FUNCTIONS.clear()
    FUNCTIONS.update(before)


class Launch(Protocol):
    """What the fixture `mpirun` returns."""

    def __call__(
        self,
        n: int,
        args: Sequence[str],
        timeout: float = 120.0,
        cwd: str | Path | None = None,
        env: Mapping[str, str] | None = None,
    ) -> subprocess.CompletedProcess[str]: ...


@pytest.fixture(scope="session")
def mpirun() -> Launch:
    """``mpirun(n, args)`` runs ``python ARGS...`` on n ranks, say ``["-m", "pgimp", case]``.

    The result has `returncode`, `stdout` and `stderr`; mpirun's own remarks are left out.
    """

    def launch(n, args, timeout=120.0, cwd=None, env=None):
        options = ["-q", "--oversubscribe", "--bind-to", "none", "-n", str(n)]
        return run(["mpirun", *options, sys.executable, *map(str, args)], timeout, cwd, env)

    return launch


@pytest.fixture(scope="session")
def python():
    """``python(args)`` runs ``python ARGS...`` as one process without a launcher, like `mpirun`."""

    def launch(args, timeout=120.0, cwd=None, env=None):
        return run([sys.executable, *map(str, args)], timeout, cwd, env)

    return launch


@pytest.fixture(scope="session")
def display():
    """Variables with the display of an X server for ParaView, one for all tests of a process.

    The server chooses its number itself, so no two can take the same, and stays as it is when its
    last client leaves: Debian's otherwise begins anew, and refuses who comes in the meantime.
    """
    for program in ("pvpython", "Xvfb"):
        words = "is not installed: apt-get install paraview python3-paraview xvfb"
        assert shutil.which(program), f"{program} {words}"
    options = ["-screen", "0", "1280x1024x24", "-nolisten", "tcp", "-noreset"]
    said, tells = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(tells), *options],
        pass_fds=[tells],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(tells)
    try:
        with os.fdopen(said) as file:
            number = file.readline().strip()
        assert number, "Xvfb did not start"
        yield {"DISPLAY": f":{number}"}
    finally:
        server.terminate()
        server.wait()


@pytest.fixture(scope="session")
def pvpython(display):
    """``pvpython(*words)`` runs it, without variables that are for another Python or for MPI."""
    other = ("PYTHON", "VIRTUAL_ENV")

    def launch(*words, cwd=None):
        env = {k: v for k, v in clean_env(display).items() if not k.startswith(other)}
        return subprocess.run(
            ["pvpython", *map(str, words)],
            env=env,
            capture_output=True,
            text=True,
            timeout=120,
            cwd=cwd,
        )

    return launch
