"""Each diagnosis of ``pgimp doctor``, provoked: by stand-ins where the real cause is too heavy."""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import namedtuple

import pytest
from processes import LAUNCHER_VARIABLES

from pgimp.cli import main
from pgimp.tools.doctor import hdf5, kernels, machine, mpi, probe

OPEN_MPI = {"version": "4.1", "library": "Open MPI v4.1.4", "files": [], "chooses": True}

# As MPICH's: it refuses Open MPI's options, and its ranks are strangers to Open MPI's library.
OTHER_MPIRUN = """#!/bin/bash
[ "$1" != --version ] || { echo "HYDRA build details:"; echo "    Version:  4.0.2"; exit; }
[ "$1" = -n ] || { echo "unrecognized argument $1" >&2; exit 1; }
shift 2
PMI_SIZE=2 PMI_RANK=0 MPI_LOCALNRANKS=2 "$@" &
PMI_SIZE=2 PMI_RANK=1 MPI_LOCALNRANKS=2 "$@"
wait
"""

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


@pytest.fixture(autouse=True)
def no_launcher(monkeypatch):
    for name in [name for name in os.environ if name.startswith(LAUNCHER_VARIABLES)]:
        monkeypatch.delenv(name)


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """``programs(name, text)`` puts a program before all others."""
    folder = tmp_path / "mpi" / "bin"
    folder.mkdir(parents=True)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")

    def add(name, text):
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
        return folder / name

    return add


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


def only(findings):
    (finding,) = findings
    return finding


def test_this_environment_is_sound(python):
    done = python(["-m", "pgimp", "doctor"], timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    for part in ("Numba", "mpi4py", "h5py", "mpirun", "two ranks"):
        assert f"\nok     {part} " in done.stdout
    assert sys.executable in done.stdout


# --- MPI -----------------------------------------------------------------------------------------


def test_mpirun_of_another_mpi(programs, tmp_path, capsys):
    programs("mpirun", OTHER_MPIRUN)
    library = tmp_path / "mpi" / "lib" / "libmpi.so.12"
    library.parent.mkdir()
    library.touch()
    assert main(["doctor"]) == 1
    said = capsys.readouterr().out
    assert "HYDRA build details: Version: 4.0.2" in said
    assert "WRONG  two ranks    mpirun and mpi4py's Open MPI" in said
    assert "do not belong together: each process is alone" in said
    assert f"export MPI4PY_LIBMPI={library}; or remove .venv and run scripts/setup" in said


def test_answers_of_ranks_that_share_a_line(programs):
    """As written with PYTHONUNBUFFERED=1, where a line's end comes after another rank's line."""
    launcher = programs("launcher", '#!/bin/bash\nprintf \'hello\\n{"a": 1}{"a": 2}\\n\\n\'\n')
    assert probe.ask_all("", launch=[str(launcher)]) == [{"a": 1}, {"a": 2}]


def test_mpi4py_built_for_another_mpi_cannot_be_told_its_library(programs):
    mpirun = str(programs("mpirun", OTHER_MPIRUN))
    cure = mpi.cure(OPEN_MPI | {"chooses": False}, mpirun)
    assert "MPI4PY_LIBMPI" not in cure
    assert "scripts/setup, which builds mpi4py" in cure


def test_mpi_library_that_is_not_there(python):
    done = python(["-m", "pgimp", "doctor"], env={"MPI4PY_LIBMPI": "/nowhere/libmpi.so"})
    assert done.returncode == 1
    assert "WRONG  mpi4py" in done.stdout
    assert "What to do:\n  mpi4py: load the module" in done.stdout


def test_one_rank_is_enough_where_there_is_no_mpi(monkeypatch, capsys):
    """mpi4py's words on a machine without any MPI library, and no launcher."""
    words = "cannot load MPI library\\nlibmpi.so.12: cannot open\\nlibmpi.so.40: cannot open"
    monkeypatch.setattr(mpi, "PROBE", f'raise RuntimeError("{words}")')
    monkeypatch.setenv("PATH", "/nowhere")
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out
    assert "note   mpi4py       finds no MPI library: one rank only" in said
    assert "pgimp works here" in said


def test_a_launcher_is_started_as_people_do(programs, monkeypatch):
    """Open MPI's mpirun in /bin, called by its path, takes / for its prefix and refuses."""
    name = programs("mpirun", "#!/bin/bash\n")
    words = []
    monkeypatch.setattr(mpi, "ask", lambda *args, launch: words.append(launch) or {"ranks": 2,
                        "parallel": False})  # fmt: skip
    assert not mpi._two_ranks(OPEN_MPI, str(name), mpi._MPIRUN).broken
    assert words[0][0] == "mpirun"


def test_launcher_that_does_not_start(programs, monkeypatch):
    programs("mpirun", "#!/bin/bash\n[ $1 = --version ] || echo 'no daemon here' >&2; exit 3\n")
    monkeypatch.delenv("SLURM_JOB_ID", raising=False)
    monkeypatch.setenv("PATH", f"{os.environ['PATH'].partition(os.pathsep)[0]}:/bin")
    finding = list(mpi.launchers(OPEN_MPI))[1]
    assert (finding.mark, finding.found) == ("WRONG", "no daemon here")


def in_a_job(monkeypatch, nodes=1):
    monkeypatch.setenv("SLURM_JOB_ID", "7")
    monkeypatch.setenv("SLURM_NTASKS", "2")
    monkeypatch.setenv("SLURM_JOB_NUM_NODES", str(nodes))


def of_srun(findings):
    return [finding for finding in findings if finding.part in ("srun", "nodes")]


def test_srun_is_left_alone_outside_of_a_job(programs):
    programs("srun", "#!/bin/bash\necho would wait in the queue >&2; exit 1\n")
    programs("mpirun", "#!/bin/bash\nexit 1\n")
    finding = only(of_srun(mpi.launchers("no MPI")))
    assert finding.mark == "ok"
    assert "salloc -n 2 pgimp doctor" in finding.found


def test_srun_that_needs_to_be_told_how_to_reach_the_library(programs, monkeypatch):
    """Two strangers by default; with --mpi=pmix two ranks, here those of the real mpirun."""
    real = shutil.which("mpirun")
    strangers = '"$@" & "$@"; wait'
    programs(
        "srun",
        f'#!/bin/bash\ncase $2 in --mpi=pmix) shift 4; exec {real} --oversubscribe -n 2 "$@" ;; '
        f"esac\nshift 3; {strangers}\n",
    )
    programs("mpirun", "#!/bin/bash\nexit 1\n")
    in_a_job(monkeypatch)
    finding = only(of_srun(mpi.launchers(OPEN_MPI)))
    assert finding.mark == "note"
    assert "with --mpi=pmix, without each is alone" in finding.found
    assert "pgimp batch CASE.yaml --launcher 'srun --mpi=pmix'" in finding.cure


def test_srun_that_does_not_know_the_library(programs, monkeypatch):
    options = 'while [ "${1#-}" != "$1" ]; do [ "$1" != -n ] || shift; shift; done'
    programs("srun", f'#!/bin/bash\n{options}\n"$@" & "$@"; wait\n')
    programs("mpirun", "#!/bin/bash\nexit 1\n")
    in_a_job(monkeypatch)
    finding = only(of_srun(mpi.launchers(OPEN_MPI)))
    assert finding.mark == "note"
    assert "srun and mpi4py's Open MPI v4.1.4 do not belong together" in finding.found
    assert "--mpi=list" in finding.cure


@pytest.mark.parametrize(("second", "mark"), [("znver4", "ok"), ("skylake-avx512", "note")])
def test_nodes_of_a_job_with_different_cpus(programs, monkeypatch, second, mark):
    srun = programs(
        "srun",
        f"""#!/bin/bash
echo '{{"host": "n1", "cpu": ["znver4", "+avx2"]}}'
echo '{{"host": "n2", "cpu": ["{second}", "+avx2"]}}'
""",
    )
    in_a_job(monkeypatch, nodes=2)
    finding = only(mpi.nodes([str(srun)], "SLURM_JOB_NUM_NODES"))
    assert finding.mark == mark
    assert ("n1, n2" in finding.found) == (mark == "ok")
    assert ("--extra=--constraint=TYPE" in finding.cure) == (mark == "note")


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
