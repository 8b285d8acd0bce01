"""What ``pgimp doctor`` says of MPI, provoked by stand-ins where the cause is too heavy."""

import os
import shutil

import pytest
from doctor_findings import OPEN_MPI, only

from pgimp.cli import main
from pgimp.utilities.doctor import mpi, probe

pytestmark = pytest.mark.slow(30)

# As MPICH's: it refuses Open MPI's options, and its ranks are strangers to Open MPI's library.
OTHER_MPIRUN = """#!/bin/bash
[ "$1" != --version ] || { echo "HYDRA build details:"; echo "    Version:  4.0.2"; exit; }
[ "$1" = -n ] || { echo "unrecognized argument $1" >&2; exit 1; }
shift 2
PMI_SIZE=2 PMI_RANK=0 MPI_LOCALNRANKS=2 "$@" &
PMI_SIZE=2 PMI_RANK=1 MPI_LOCALNRANKS=2 "$@"
wait
"""


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
