"""Kernels compiled before cases are run: all of them, and whole ones if that is interrupted."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest
from processes import clean_env
from scenes import box, scene, write_case

from pgimp.jit.compiled import sealed

AHEAD = [sys.executable, "-m", "pgimp.running.compile_ahead"]


@pytest.fixture
def cases(tmp_path):
    """A bar, and one whose steps are chosen by the speed of sound."""
    for name, step in (("fixed", 0.05), ("chosen", {"courant": 0.3})):
        case = scene(1, box([1.0], [3.0]), cells=[6], end=0.2, step=step)
        write_case(tmp_path / f"{name}.yaml", case)
    return ["fixed.yaml", "chosen.yaml"]


def members(group):
    """Whether processes of a group are there."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_runs_find_all_their_kernels(tmp_path, cases, mpirun):
    """Also after one that was ended in between, and on two ranks; a case that is none is named."""
    env = clean_env({"PGIMP_CACHE_DIR": str(tmp_path / "kernels")})
    begun = subprocess.Popen(
        [*AHEAD, *cases], env=env, cwd=tmp_path, start_new_session=True,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    until = time.monotonic() + 60.0
    while len(files := list(tmp_path.glob("kernels/*/**/*.nbc"))) < 3:
        assert begun.poll() is None and time.monotonic() < until
        time.sleep(0.01)
    begun.send_signal(signal.SIGTERM)
    assert "interrupted; kernels that were compiled are kept" in begun.communicate()[1]
    assert begun.returncode == 1 and not members(begun.pid)
    assert all(sealed.read(path) for path in files)

    words = [*AHEAD, *cases, "none.yaml"]
    done = subprocess.run(words, env=env, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert re.search(r"2 of 3 cases have all their kernels, after \d+ s", done.stdout)
    assert done.stderr.startswith("none.yaml: cannot read the case none.yaml: No such file")
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("kernels/*/**/*.nbc")}
    assert len(kept) > 10
    for name in cases:
        run = mpirun(2, ["-m", "pgimp", name], env=env, cwd=tmp_path)
        assert run.returncode == 0, run.stderr
        assert "compiling for this kind" not in run.stdout + run.stderr
    now = {path: path.stat().st_mtime_ns for path in tmp_path.glob("kernels/*/**/*.nbc")}
    assert now == kept


def test_without_cases_it_says_what_it_is_for():
    done = subprocess.run(AHEAD, capture_output=True, text=True)
    assert done.returncode == 2 and "python -m pgimp.running.compile_ahead CASE" in done.stdout
