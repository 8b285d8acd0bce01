"""The kernel cache as runs use it: found again, said, renewed when damaged, moved, refused."""

import os
import random
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from cache_words import COMPILING
from scenes import box, scene, write_case

import pgimp
from pgimp.errors import UsageError
from pgimp.jit.compiled.folder import COMPILED, preferred_folder
from pgimp.jit.kernel import FOLDER

pytestmark = pytest.mark.slow(30)

SEED = 20041

PACKAGE = Path(pgimp.__file__).parent
RUN = """
import numpy as np
from pgimp.jit.compiled.cache import announced, messages
from pgimp.jit.kernel import FOLDER
from pgimp.kernels.order.order import locate
from pgimp.physics.shapes.mpm import MpmParameters
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.particles import Particles


p = Particles.empty(1, Carried(1))
p.x[0, 0] = 2.5
frame = Frame((0.0,), (1.0,), (1.0,), (4,), 1)
with announced(print):
    locate(MpmParameters((0.0,)), frame, p, np.zeros(1, np.int32), frame.vertices)
print(*messages(), sep="\\n")
print(FOLDER.path, p.layer[0], sum(locate.stats.cache_hits.values()))
"""


def run(folder: Path) -> tuple[Path, int, int, str]:
    """Folder of the kernels, the answer of one, how many were in the cache; what was said."""
    env = {**os.environ, "PGIMP_CACHE_DIR": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", RUN], env=env, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    *said, last = done.stdout.splitlines()
    path, layer, hits = last.split()
    return Path(path), int(layer), int(hits), "\n".join(said).strip()


def test_second_process_finds_the_kernels(tmp_path):
    assert run(tmp_path / "a")[1:] == (3, 0, COMPILING)
    assert run(tmp_path / "a")[1:] == (3, 1, "")


@pytest.fixture(scope="module")
def small(tmp_path_factory, python):
    """A folder with a case in 1D and its run, and a copy of all kernels there are, for tests."""
    folder = tmp_path_factory.mktemp("small")
    write_case(folder / "case.yaml", scene(1, box([1], [3], [0.3]), end=0.02))
    done = python(["-m", "pgimp", "case.yaml", "-o", "right"], cwd=folder)
    assert done.returncode == 0, done.stderr
    kernels = folder / "cache" / FOLDER.path.name
    kernels.mkdir(mode=0o700, parents=True)
    for path in FOLDER.path.glob("*.nbc"):
        shutil.copy(path, kernels)
    (folder / "cache").chmod(0o700)
    return folder


def at(folder):
    return {"PGIMP_CACHE_DIR": str(folder)}


def some_kernels(folder):
    """Files of small kernels of the case, which are compiled fast."""
    kept = sorted((folder / "cache").glob("kernels-*/*.nbc"))
    small = re.compile(r"\.(grow_vertex_bounds|sort_rows|partition_migrants)-")
    found = [path for path in kept if small.search(path.name)]
    assert len(found) >= 3
    return found


def test_a_run_says_when_it_compiles(small, python):
    words = ["-m", "pgimp", "case.yaml", "--overwrite", "-o", "out"]
    for path in some_kernels(small):
        path.unlink()
    for times in (1, 0):
        done = python(words, cwd=small, env=at(small / "cache"))
        assert done.returncode == 0, done.stderr
        assert done.stdout.count(COMPILING) == times
        assert (small / "out/log.txt").read_text().count(COMPILING) == times


#: What a plain run does not use, and what only compiles.
UNUSED = {"matplotlib", "meshio", "scipy", "rich", "mpi4py.MPI", "multiprocessing", "ssl",
          "urllib.request", "pgimp.jit.tracing.kernel", "pgimp.utilities",
          "pgimp.solver.contact.multifield", "pgimp.kernels.contact.impulses"}  # fmt: skip


def test_a_run_with_kernels_on_disk_imports_only_what_it_uses(small, python):
    program = "import sys; from pgimp.cli import main; main(sys.argv[1:]); print(*sys.modules)"
    words = ["case.yaml", "--overwrite", "-o", "plain", "--quiet"]
    for _ in range(2):  # where another test has removed some kernels
        done = python(["-c", program, *words], cwd=small, env=at(small / "cache"))
    assert done.returncode == 0, done.stderr
    imported = {*done.stdout.split()}
    assert "pgimp.solver.step" in imported
    assert sorted(imported & UNUSED) == []


CALLER = """
import numba, numpy as np
from pgimp.jit.kernel import kernel

@kernel
def total(values, weight):
    found = 0.0
    for value in values:
        found += weight * value
    return found

@numba.njit
def twice(values):
    return total(values, 1.0) + total(values, 1.0)

print(twice(np.arange(4.0)), sum(total.stats.cache_hits.values()))
"""


def test_a_function_of_numba_calls_a_kernel_from_the_disk(tmp_path, python):
    """It is compiled together with the kernel's instructions, which are not read otherwise."""
    (tmp_path / "caller.py").write_text(CALLER, encoding="utf-8")
    for hits in (0, 1):
        done = python([tmp_path / "caller.py"], env=at(tmp_path / "cache"))
        assert (done.stdout, done.returncode) == (f"12.0 {hits}\n", 0), done.stderr


def test_a_simulation_in_a_program_is_silent(small, python):
    for path in some_kernels(small):
        path.unlink()
    program = "import pgimp; pgimp.Simulation('case.yaml').step()"
    done = python(["-c", program], cwd=small, env=at(small / "cache"))
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert some_kernels(small)


def test_a_run_with_damaged_kernels_is_the_same(small, python, mpirun):
    """One bit in each of some files; on one rank quietly, on two with a word for all."""
    folder, rng = small, random.Random(SEED)
    for launch, quiet in ((lambda *given, **more: mpirun(2, *given, **more), ""), (python, "yes")):
        for path in some_kernels(folder):
            damaged = bytearray(path.read_bytes())
            damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
            path.write_bytes(damaged)
        words = ["-m", "pgimp", "case.yaml", "--overwrite", "-o", "again"]
        words += ["--quiet"] if quiet else []
        done = launch(words, cwd=folder, env=at(folder / "cache"))
        assert done.returncode == 0, done.stderr
        told = "note: compiled kernels were not used but compiled again: "
        assert (told in done.stdout) is not bool(quiet)
        log = (folder / "again/log.txt").read_text()
        assert log.count(told) == 1 and log.count(COMPILING) == 1
        for path in (folder / "right/frames").iterdir():
            assert path.read_bytes() == (folder / "again/frames" / path.name).read_bytes()


def test_unwritable_cache_moves_to_a_temporary_folder(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("a folder cannot be made here")
    folder, layer, _, _ = run(blocked)
    assert layer == 3
    assert blocked not in folder.parents


def test_a_cache_that_is_not_used_is_said(small, python):
    folder = small
    shared = folder / "shared"
    shared.mkdir()
    shutil.copytree(folder / "cache", folder / "tmp" / f"pgimp-{os.geteuid()}")
    shared.chmod(0o777)
    words = ["-m", "pgimp", "case.yaml", "-o", "shared.out"]
    done = python(words, cwd=folder, env=at(shared) | {"TMPDIR": str(folder / "tmp")})
    assert done.returncode == 0
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("warning: ")]
    assert "shared cannot be trusted: others may write to it (mode 0777)" in line
    assert "PGIMP_CACHE_DIR names another folder" in line
    assert "compiling" not in done.stdout


def test_an_empty_cache_folder_is_refused(small, monkeypatch, python, mpirun):
    folder = small
    for given in ("", "  "):
        monkeypatch.setenv("PGIMP_CACHE_DIR", given)
        with pytest.raises(UsageError, match="is set but empty: name a folder"):
            preferred_folder()
    words = ["-m", "pgimp", "case.yaml", "-o", "none"]
    for done in (python(words, cwd=folder), mpirun(2, words, cwd=folder)):
        assert done.returncode == 2
        assert done.stderr.count("PGIMP_CACHE_DIR, the folder of the compiled kernels, is set") == 1
        assert "Traceback" not in done.stderr
    assert not (folder / "none").exists()


def test_all_that_numba_compiles_is_part_of_the_cache_name():
    marks = r"^ *@((allocating_|inner_|separate_)?kernel|inlined|exact|overload|njit|intrinsic)"
    for path in PACKAGE.rglob("*.py"):
        name = str(path.relative_to(PACKAGE))
        if re.search(marks, path.read_text(), re.M):
            assert name.startswith(COMPILED), f"{name} compiles kernels: name it in folder.COMPILED"


def test_numba_writes_no_colours(python):
    """Whatever imports it first: at the end they would stand in what a program reads."""
    text = "import pgimp.commands.bench, numba.core.errors as e; print(hasattr(e, 'ColorShell'))"
    assert python(["-c", text]).stdout.split() == ["False"]
