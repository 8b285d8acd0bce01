"""Parts of kernels are kept on disk, so that kernels of other scenes find them."""

import os
import shutil
import subprocess
import sys

import pytest
from scenes import box, scene, write_case

from pgimp.jit.compiled.compiler import _captured

pytestmark = pytest.mark.slow(30)

RUN = """
import sys
import pgimp
simulation = pgimp.Simulation(sys.argv[1])
while not simulation.finished:
    simulation.step(1)
print(simulation.particles["position"].tobytes().hex())
"""


def run(case, folder):
    """What a run gives with a cache, bit by bit, and the files of the cache: kernels, parts."""
    env = {**os.environ, "PGIMP_CACHE_DIR": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", RUN, case], env=env, capture_output=True, text=True, timeout=200
    )
    assert done.returncode == 0, done.stderr
    files = {path: path.stat().st_ino for path in folder.rglob("*.nbc")}
    parts = {path for path in files if path.parent.name == "parts"}
    return done.stdout, {path: files[path] for path in {*files} - parts}, {
        path: files[path] for path in parts
    }  # fmt: skip


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """A case, the folder of a cache with its kernels, and what `run` gave for them."""
    folder = tmp_path_factory.mktemp("parts")
    write_case(folder / "case.yaml", scene(1, box([2.0], [5.0], [1.0]), end=0.5))
    return folder / "case.yaml", folder / "cache", run(folder / "case.yaml", folder / "cache")


def test_kernels_of_parts_that_are_there_have_the_same_bits(compiled):
    """Without the kernels nothing but these is compiled again; a damaged part is replaced."""
    case, folder, (first, kernels, parts) = compiled
    assert len(kernels) > 5 and len(parts) > 3 * len(kernels)
    damaged = sorted(parts)[::7]
    for path in (*kernels, *damaged):
        path.unlink() if path in kernels else path.write_bytes(path.read_bytes()[:-1] + b"?")
    again, made, found = run(case, folder)
    assert again == first and {*made} == {*kernels} and {*found} == {*parts}
    replaced = {path for path in parts if found[path] != parts[path]}
    assert replaced and replaced <= {*damaged}  # what a whole part has in it is not looked for


def test_another_scene_shares_most_parts(compiled, tmp_path):
    """Another shape and a load: kernels are new, two thirds of what they are made of is not."""
    _, folder, (_, _, parts) = compiled
    shutil.copytree(folder, tmp_path / "cache")
    case = tmp_path / "mpm.yaml"
    write_case(case, scene(1, box([2.0], [5.0]), shape="mpm", gravity=[-1.0]))
    assert len(run(case, tmp_path / "cache")[2]) - len(parts) < len(parts) / 3


def add(number):
    return lambda x: x + number


def with_default(x, number=1):
    return x + number


def test_functions_of_one_name_are_told_apart(monkeypatch):
    """By what they have from the function that made them; where that is not known they are none."""
    for function in (one := add(1), two := add(2), same := add(1), other := add(run), with_default):
        monkeypatch.setattr(function, "__module__", "pgimp.made", raising=False)
    assert _captured(one) == _captured(same) != _captured(two)
    assert _captured(with_default) is None  # its default may be anything
    assert _captured(add(3)) is None  # of no module of the package
    assert _captured(other) is None  # has a function from elsewhere


@pytest.mark.parametrize("content", [object(), [1], {"a": 1}, (1, "a")])
def test_what_cannot_be_named_is_not_kept(content, monkeypatch):
    function = add(content)
    monkeypatch.setattr(function, "__module__", "pgimp.made")
    assert _captured(function) is None
