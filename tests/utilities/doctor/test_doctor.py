"""Each diagnosis of ``pgimp doctor`` but those of MPI, provoked: files, kernels, the machine."""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import namedtuple

import pytest
from doctor_findings import OPEN_MPI, only

from pgimp.utilities.doctor import hdf5, kernels, machine

pytestmark = pytest.mark.slow(30)

# The real h5py, changed; in its place.
OTHER_H5PY = """
import ctypes, sys
folder = sys.path.pop(next(i for i, path in enumerate(sys.path) if path == {folder!r}))
del sys.modules["h5py"]
import h5py

real = h5py.File
class Locking(real):
    def __init__(self, *args, **options):
        if options.get("locking") is not False:
            raise OSError("unable to lock file, errno = 38")
        super().__init__(*args, **options)
{change}
"""


@pytest.fixture
def other_h5py(tmp_path, monkeypatch):
    """``other_h5py(change)`` changes what processes import as h5py."""

    def change(text):
        folder = tmp_path / "python"
        folder.mkdir()
        source = OTHER_H5PY.format(folder=str(folder), change=text)
        (folder / "h5py.py").write_text(source)
        monkeypatch.setenv("PYTHONPATH", str(folder))
        monkeypatch.chdir(tmp_path)

    return change


def test_this_environment_is_sound(python):
    done = python(["-m", "pgimp", "doctor"], timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    for part in ("Numba", "mpi4py", "h5py", "mpirun", "two ranks"):
        assert f"\nok     {part} " in done.stdout
    assert sys.executable in done.stdout


# --- HDF5 ----------------------------------------------------------------------------------------


def test_h5py_with_another_mpi_library(other_h5py, tmp_path):
    library = tmp_path / "libmpi.so.12"
    words = ["gcc", "-shared", "-x", "c", "/dev/null", "-o", str(library)]
    subprocess.run(words, check=True, timeout=60)
    other_h5py(f"ctypes.CDLL({str(library)!r})")
    own = OPEN_MPI | {"files": ["/usr/lib/libmpi.so.40"]}
    finding = only(hdf5.examine(own))
    assert finding.mark == "WRONG"
    assert "brings in a second MPI (/" in finding.found
    assert str(library) in finding.found
    assert "--only-binary=h5py" in finding.cure


def test_h5py_that_cannot_be_imported(other_h5py):
    other_h5py("raise ImportError('libhdf5.so.103: cannot open shared object file')")
    finding = only(hdf5.examine(OPEN_MPI))
    assert finding.mark == "WRONG"
    assert "libhdf5.so.103" in finding.found
    assert "--only-binary=h5py" in finding.cure


def test_file_system_without_locks(other_h5py, tmp_path):
    other_h5py("h5py.File = Locking")
    finding = list(hdf5.examine(OPEN_MPI))[1]
    assert finding.mark == "note"
    assert f"cannot lock files in {tmp_path}: unable to lock file, errno = 38" in finding.found
    assert "HDF5_USE_FILE_LOCKING=FALSE" in finding.cure


def test_folder_that_cannot_be_written(monkeypatch):
    monkeypatch.chdir("/proc")
    finding = list(hdf5.examine(OPEN_MPI))[1]
    assert finding.mark == "note"
    assert "nothing can be written in /proc (" in finding.found


# --- Kernels -------------------------------------------------------------------------------------


def test_kernel_cache_that_cannot_be_written(monkeypatch):
    monkeypatch.setenv("PGIMP_CACHE_DIR", "/proc/nowhere")
    finding = next(kernels.examine())
    assert finding.mark == "note"
    assert "they belong into /proc/nowhere/kernels-" in finding.cure
    assert "(No such file or directory)" in finding.cure
    assert "export PGIMP_CACHE_DIR=" in finding.cure


def test_kernel_cache_that_others_can_write_to(tmp_path, monkeypatch):
    tmp_path.chmod(0o777)
    monkeypatch.setenv("PGIMP_CACHE_DIR", str(tmp_path))
    finding = next(kernels.examine())
    assert finding.mark == "note"
    assert f"{tmp_path} cannot be trusted: others may write to it (mode 0777)" in finding.cure


def test_kernel_cache_without_a_name(monkeypatch):
    monkeypatch.setenv("PGIMP_CACHE_DIR", "")
    finding = only(kernels.examine())
    assert finding.mark == "WRONG"
    assert "name a folder, or unset it" in finding.cure


def test_numba_that_must_not_compile(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    finding = next(kernels.examine())
    assert finding.mark == "note"
    assert "unset NUMBA_DISABLE_JIT" in finding.cure


def test_numba_that_does_not_work(monkeypatch):
    monkeypatch.setattr(kernels, "PROBE", "raise ImportError('no llvmlite')")
    finding = only(kernels.examine())
    assert (finding.mark, finding.found) == ("WRONG", "ImportError: no llvmlite")


def test_kernels_of_different_cpus(tmp_path, monkeypatch):
    """Compiled twice into one folder, as by two nodes: for this CPU, and for a plain one."""
    (tmp_path / "add.py").write_text(
        "from pgimp.jit.kernel import kernel\n@kernel\ndef add(x): return x + 1\nadd(1)\n"
    )
    monkeypatch.setenv("PGIMP_CACHE_DIR", str(tmp_path / "cache"))

    def compile_for(**cpu):
        words = [sys.executable, str(tmp_path / "add.py")]
        subprocess.run(words, check=True, timeout=60, env={**os.environ, **cpu})

    compile_for()
    assert len(kernels.cached_targets(tmp_path / "cache")) == 1
    assert list(kernels.types_of_cpu(tmp_path / "cache")) == []
    compile_for(NUMBA_CPU_NAME="nehalem", NUMBA_CPU_FEATURES="+sse4.2,-avx")
    finding = only(kernels.types_of_cpu(tmp_path / "cache"))
    assert finding.mark == "note"
    assert "nehalem" in finding.found
    assert "nodes of one type only" in finding.cure
    for path in (tmp_path / "cache").rglob("*.nbc"):
        path.write_bytes(b"damaged")
    assert kernels.cached_targets(tmp_path / "cache") == set()


# --- The machine ---------------------------------------------------------------------------------


def test_packages_that_hide_those_installed(tmp_path, monkeypatch):
    (tmp_path / "h5py").mkdir()
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    finding = machine.python()
    assert finding.mark == "note"
    assert f"PYTHONPATH has another h5py in {tmp_path}" in finding.found
    monkeypatch.delenv("PYTHONPATH")
    assert machine.python().mark == "ok"


def test_little_shared_memory(tmp_path):
    finding = only(machine.shared_memory(1 << 40, str(tmp_path)))
    assert finding.mark == "note"
    assert "--shm-size" in finding.cure
    assert list(machine.shared_memory(0, str(tmp_path))) == []
    assert list(machine.shared_memory(1 << 40, str(tmp_path / "none"))) == []


def test_folder_for_temporary_files_too_deep_or_full(tmp_path, monkeypatch):
    deep = tmp_path / ("a" * 60)
    deep.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(deep))
    assert "set TMPDIR to a short path" in only(machine.temporary_folder()).cure
    monkeypatch.setattr(tempfile, "tempdir", "/tmp")
    usage = namedtuple("usage", "free")
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: usage(3 << 20))
    assert "3 MB are free in /tmp" in only(machine.temporary_folder()).found


def test_more_threads_than_a_user_may_have(monkeypatch):
    monkeypatch.setattr(resource, "getrlimit", lambda which: (4096, 4096))
    assert "OMP_NUM_THREADS=1" in only(machine.threads(128, {})).cure
    assert list(machine.threads(128, {"OMP_NUM_THREADS": "1"})) == []
    assert list(machine.threads(16, {})) == []
