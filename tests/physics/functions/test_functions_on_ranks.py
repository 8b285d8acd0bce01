"""Runs with a function of one's own of each kind: the same bits on any ranks, and resumed."""

import shutil
from pathlib import Path

import pytest
from run_files import digests, go_back
from scenes import box, scene, write_case

import pgimp

pytestmark = pytest.mark.slow(60)

#: The functions of random scenes.
FILE = Path(__file__).parents[3] / "scripts/proofs/scenes/own/random_functions.py"


def named(function, **parameters):
    return {"function": function, "parameters": parameters}


def case():
    """A block of varying density that crosses slabs, with all that functions may give."""
    body = box([2.0, 1.0], [14.0, 4.0]) | {"velocity": named("rippling", size=1.0, wave=0.6)}
    force = named("swaying", strength=0.5, drag=0.3, wave=0.4, rate=5.0)
    push = named("breathing", mean=0.3, swing=0.4, rate=8.0)
    found = scene(
        2, body, cells=[18, 6], end=0.6, step={"courant": 0.3}, body_force=force,
        gravity=[push, -0.5], start={"stress": named("squeezing", p=0.8, wave=0.7, mean=0.0)},
        boundaries={"y-min": "slip"}, checkpoint={"every": {"steps": 5}, "keep": 9},
        output={"every": 0.2, "fields": ["velocity", "stress"]}, history={"every": {"steps": 4}},
    )  # fmt: skip
    held = {"body": "body", "region": {"box": {"min": [6.0, 1.0], "max": [9.0, 2.5]}}}
    drift = named("drifting", size=2.0, wave=0.4, rate=4.0)
    found["constraints"] = {"grip": held | {"velocity": drift}}
    density = named("patchy", mean=1.0, part=0.3, wave=0.5)
    found["materials"]["soft"] = found["materials"]["soft"] | {"density": density}
    return found


def test_bits_do_not_depend_on_ranks_nor_on_a_kill(tmp_path, mpirun, python):
    write_case(tmp_path / "case.yaml", case())
    words = ["-m", "pgimp", "case.yaml", "--import", FILE, "--quiet", "-o"]
    done = python([*words, "1"], 300, tmp_path)
    assert done.returncode == 0, done.stderr
    done = mpirun(3, [*words, "3"], 300, tmp_path)
    assert done.returncode == 0, done.stderr
    shutil.copytree(tmp_path / "3", tmp_path / "5")
    go_back(tmp_path / "5", 0.5)
    done = mpirun(5, [*words, "5", "--resume"], 300, tmp_path)
    assert done.returncode == 0, done.stderr
    assert pgimp.open(tmp_path / "5").info["resumed_from"] >= 10
    assert digests(tmp_path / "1") == digests(tmp_path / "3") == digests(tmp_path / "5")
    known = pgimp.open(tmp_path / "5").info["functions"]
    assert len(known) == 6 and known == pgimp.open(tmp_path / "1").info["functions"]
    done = python([*words[:3], "-o", "none"], 120, tmp_path)
    assert done.returncode == 2
    assert "unknown body force 'swaying'" in done.stderr and "--import FILE.py" in done.stderr


RAISES = """
import numba
import pgimp

@numba.njit
def reading(t, until):
    if t > until:
        raise ValueError("no data")
    return 1.0

@pgimp.body_force
def pulling(x, t, until):
    return reading(t, until), 0.0

@pgimp.body_force
def ending(x, t, until):
    if t > until:
        raise ValueError("the table ends here")
    return 1.0, 0.0
"""


def test_errors_name_the_copy_that_ran_not_the_one_whose_kernels_are_on_disk(tmp_path, python):
    """Kernels kept on disk serve every copy of a file, as in the folders of a study."""
    for name in "first", "second":
        folder = tmp_path / name
        folder.mkdir()
        (folder / "their_data.py").write_text(RAISES)
        for function in "pulling", "ending":
            force = named(function, until=0.05)
            body = box([1.0, 1.0], [3.0, 3.0])
            given = scene(2, body, cells=[4, 4], end=0.6, body_force=force)
            write_case(folder / f"{function}.yaml", given)
        words = ["--import", "their_data.py", "--quiet", "-o"]
        done = python(["-m", "pgimp", "ending.yaml", *words, "1"], 120, folder)
        told = f"the body force 'ending' ({folder}/their_data.py:15) raises ValueError: the table"
        assert done.returncode == 1 and told in done.stderr, done.stderr
        done = python(["-m", "pgimp", "pulling.yaml", *words, "2"], 120, folder)
        told = f"the function 'reading' ({folder}/their_data.py:8) raises ValueError: no data"
        assert done.returncode == 1 and told in done.stderr, done.stderr
