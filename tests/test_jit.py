"""The kernel cache: found again, renewed when damaged, moved when it cannot be written."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

import pgimp
from pgimp.kernels.jit import COMPILED, cache_folder

PACKAGE = Path(pgimp.__file__).parent

RUN = """
import glob, os, sys
from pgimp.kernels import jit
from pgimp.kernels.order import locate
from pgimp.shapes.mpm import MpmParameters
from pgimp.solver.particles import Frame, Particles
import numpy as np

def call():
    p = Particles.empty(1, 1, False)
    p.x[0, 0] = 2.5
    frame = Frame((0.0,), (1.0,), (1.0,), (4,), 1)
    locate(MpmParameters((0.0,)), frame, p, np.zeros(1, np.int32), frame.vertices)
    return int(p.layer[0])

layer = jit.discard_damaged(call)
print(jit.cache_folder(), layer, sum(locate.stats.cache_hits.values()))
"""


def run(cache: Path) -> tuple[Path, int, int]:
    env = {**os.environ, "PGIMP_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", RUN], env=env, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    folder, layer, hits = done.stdout.split()
    return Path(folder), int(layer), int(hits)


def test_second_process_finds_the_kernels(tmp_path):
    assert run(tmp_path)[1:] == (3, 0)
    assert run(tmp_path)[1:] == (3, 1)


@pytest.mark.parametrize("damage", [b"", b"not a pickle", None])
def test_damaged_cache_is_renewed(tmp_path, damage):
    folder, _, _ = run(tmp_path)
    files = [path for path in folder.rglob("*") if path.suffix in (".nbi", ".nbc")]
    assert files
    for path in files:
        path.write_bytes(path.read_bytes()[:-100] if damage is None else damage)
    assert run(tmp_path)[1] == 3
    assert run(tmp_path)[1:] == (3, 1)


def test_unwritable_cache_moves_to_a_temporary_folder(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("a folder cannot be made here")
    folder, layer, _ = run(blocked)
    assert layer == 3
    assert blocked not in folder.parents


def test_a_temporary_folder_that_others_can_write_to_is_not_used(tmp_path, monkeypatch):
    """Numba executes what it finds in its cache."""
    (tmp_path / "file").write_text("a folder cannot be made here")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("PGIMP_CACHE_DIR", str(tmp_path / "file"))
    usual = tmp_path / f"pgimp-{os.getuid()}"
    assert cache_folder().parent == usual
    assert usual.stat().st_mode & 0o777 == 0o700
    usual.chmod(0o777)
    assert cache_folder().parent != usual
    usual.rmdir()
    usual.symlink_to(tmp_path)
    assert cache_folder().parent != usual


def test_all_that_numba_compiles_is_part_of_the_cache_name():
    for path in PACKAGE.rglob("*.py"):
        name = str(path.relative_to(PACKAGE))
        if re.search(r"^ *@(kernel|specialise|overload|njit|intrinsic)", path.read_text(), re.M):
            assert name.startswith(COMPILED), f"{name} compiles kernels: name it in jit.COMPILED"
