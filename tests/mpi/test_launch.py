"""One rank or many: which launcher it was, and how ranks fail together."""

import pytest
from mentioned import mentions

from pgimp.errors import UsageError
from pgimp.mpi.comm import Serial, abort_on_error, launcher

pytestmark = pytest.mark.slow(135)

TRACEBACK_HINT = "(set PGIMP_TRACEBACK=1 for the traceback)"


@pytest.mark.parametrize(
    ("environ", "expected"),
    [
        ({}, None),
        ({"OMPI_COMM_WORLD_SIZE": "4", "OMPI_COMM_WORLD_RANK": "3"}, ("Open", 4, 3)),
        ({"PMI_SIZE": "2", "PMI_RANK": "1", "MPI_LOCALNRANKS": "2"}, ("MPICH", 2, 1)),
        ({"PMI_SIZE": "2", "PMI_RANK": "0", "I_MPI_HYDRA_HOST_FILE": "x"}, ("Intel", 2, 0)),
        ({"PMIX_RANK": "5"}, ("PMIx", None, 5)),
        ({"PALS_RANKID": "1", "PALS_APID": "a"}, ("PALS", None, 1)),
        # As libraries see it that their launcher does not reach.
        ({"MPI_LOCALRANKID": "1", "MPI_LOCALNRANKS": "2"}, ("MPICH", 2, 1)),
        ({"PMI_RANK": "1", "MPI_LOCALNRANKS": "1"}, ("MPICH", None, 1)),
        ({"SLURM_PROCID": "0", "SLURM_NTASKS": "2"}, ("Slurm", 2, 0)),
        ({"SLURM_PROCID": "1", "SLURM_NTASKS": "2", "SLURM_JOB_ID": "9"}, ("Slurm", 2, 1)),
        # An sbatch script: tasks are promised, none is started.
        ({"SLURM_JOB_ID": "9", "SLURM_NTASKS": "8", "SLURM_PROCID": "0"}, None),
        # The step that Slurm makes for an interactive shell.
        ({"SLURM_STEP_ID": "4294967290", "SLURM_PROCID": "0", "SLURM_NTASKS": "8"}, None),
        ({"SLURM_STEP_ID": "0", "SLURM_STEP_NUM_TASKS": "3", "SLURM_PROCID": "2"}, ("Slurm", 3, 2)),
        ({"SLURM_STEP_ID": "0", "SLURM_NTASKS": "8", "SLURM_PROCID": "2"}, ("Slurm", 8, 2)),
        # mpirun within a Slurm step: the ranks are mpirun's.
        (
            {
                "SLURM_STEP_ID": "0",
                "SLURM_STEP_NUM_TASKS": "2",
                "SLURM_PROCID": "1",
                "OMPI_COMM_WORLD_SIZE": "16",
                "OMPI_COMM_WORLD_RANK": "9",
            },
            ("Open", 16, 9),
        ),
    ],
)
def test_launcher_is_recognised(environ, expected):
    found = launcher(environ)
    if expected is None:
        assert found is None
    else:
        name, size, rank = expected
        assert name in found.name
        assert (found.size, found.rank) == (size, rank)


def test_serial_behaves_like_one_rank(mpirun):
    """Serial and a world of one rank answer the same; the script prints what each says."""
    comm = Serial()
    answers = (
        f"{comm.rank} {comm.size} {comm.bcast('a')} "
        f"{comm.gather(3)} {comm.allgather(3)} {comm.allreduce(2.5)} {comm.Barrier()}"
    )
    script = """
from mpi4py import MPI
comm = MPI.COMM_WORLD
print(comm.rank, comm.size, comm.bcast('a'),
      comm.gather(3), comm.allgather(3), comm.allreduce(2.5), comm.Barrier())
"""
    assert mpirun(1, ["-c", script]).stdout.strip() == answers


def test_without_launcher_mpi_is_not_even_imported(python):
    script = """
import sys
from pgimp.mpi.comm import Serial, world
assert type(world()) is Serial
assert "mpi4py.MPI" not in sys.modules
import h5py  # with MPI, it would initialise it
if "mpi4py.MPI" in sys.modules:
    assert not sys.modules["mpi4py.MPI"].Is_initialized()
print("fine")
"""
    done = python(["-c", script])
    assert done.stdout == "fine\n", done.stderr


def test_world_under_mpirun(mpirun):
    script = """
from pgimp.mpi.comm import world
comm = world()
answers = comm.gather((comm.size, comm.allreduce(comm.rank)))
if comm.rank == 0:
    print(answers)
"""
    done = mpirun(3, ["-c", script])
    assert done.stdout == "[(3, 3), (3, 3), (3, 3)]\n", done.stderr


WRONG_LAUNCHER = """
import sys
from pgimp.errors import PgimpError
from pgimp.mpi.comm import world
try:
    world()
except PgimpError as error:
    print(error)
    sys.exit(error.exit_status)
"""


def test_launcher_of_another_mpi_is_named_beside_the_library(python):
    """A process that MPICH's launcher claims to have started, with Open MPI's library."""
    env = {"PMI_SIZE": "4", "PMI_RANK": "0", "MPI_LOCALNRANKS": "4"}
    done = python(["-c", WRONG_LAUNCHER], env=env)
    assert done.returncode == 2, done.stderr
    assert "mpiexec of MPICH" in done.stdout
    assert "4 processes" in done.stdout
    assert "Open MPI v" in done.stdout
    assert "Traceback" not in done.stderr


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text("format: 1\n")
    return path


def test_run_command_reports_wrong_launcher_once(python, case):
    env = {"PMI_SIZE": "4", "PMI_RANK": "0", "MPI_LOCALNRANKS": "4"}
    first = python(["-m", "pgimp", case], env=env, cwd=case.parent)
    assert first.returncode == 2
    assert first.stderr.startswith("pgimp: the mpiexec of MPICH")
    assert not list(case.parent.glob("*.out"))
    other = python(["-m", "pgimp", case], env=env | {"PMI_RANK": "1"}, cwd=case.parent)
    assert (other.returncode, other.stderr) == (2, "")


@pytest.mark.parametrize(
    ("env", "words"),
    [
        ({"SLURM_PROCID": "{}", "SLURM_NTASKS": "2"}, ["Slurm's srun", "(SLURM_PROCID)", "pmix"]),
        ({"MPI_LOCALRANKID": "{}", "MPI_LOCALNRANKS": "2"}, ["MPICH", "(MPI_LOCALRANKID)"]),
    ],
    ids=["slurm", "local"],
)
def test_tasks_that_their_launcher_does_not_connect_do_not_run_the_case_each(
    python, case, env, words
):
    done = [
        python(["-m", "pgimp", case], env={k: v.format(rank) for k, v in env.items()},
               cwd=case.parent)
        for rank in range(2)
    ]  # fmt: skip
    assert [each.returncode for each in done] == [2, 2]
    mentions(done[0].stderr, "started 2 processes", "a world of 1 rank", *words)
    assert done[1].stderr == ""  # one of them speaks for all
    assert not list(case.parent.glob("*.out"))


def test_a_task_speaks_where_the_first_takes_itself_for_a_batch_script(python, case):
    env = {"SLURM_PROCID": "1", "SLURM_NTASKS": "2", "SLURM_JOB_ID": "9"}
    done = python(["-m", "pgimp", case], env=env, cwd=case.parent)
    assert done.returncode == 2
    mentions(done.stderr, "this is number 1 (SLURM_PROCID)")


def test_launcher_without_an_mpi_library(python):
    env = {"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "0"}
    done = python(["-c", WRONG_LAUNCHER], env=env | {"MPI4PY_LIBMPI": "/nowhere/libmpi.so"})
    assert done.returncode == 2, done.stderr
    assert "Open MPI's mpirun started 2 processes" in done.stdout
    assert "/nowhere/libmpi.so" in done.stdout


FAILING = """
import sys
from pgimp.errors import CaseError, RunError
from pgimp.mpi.comm import abort_on_error, world

comm = world()
with abort_on_error(comm):
    {statement}
    if comm.allreduce(1) == 3 and comm.rank == 0:
        print("went on")
"""


@pytest.mark.parametrize(
    ("statement", "status", "message"),
    [
        ("if comm.rank == 1: raise RunError('it broke')", 1, "pgimp: rank 1: it broke"),
        ("raise RunError('it broke')", 1, "pgimp: rank 0: it broke"),
        ("if comm.rank: raise RunError('it broke')", 1, "pgimp: rank 1: it broke"),
        ("raise CaseError('wrong case')", 2, "pgimp: wrong case"),
        (
            "if comm.rank == 2: 1 // 0",
            1,
            "pgimp: rank 2: unexpected ZeroDivisionError: integer division or modulo by zero "
            + TRACEBACK_HINT,
        ),
        # The others wait in the barrier: the wrong case of one rank must not leave them there.
        (
            "if comm.rank == 0: raise RunError('it broke')\n    else: raise CaseError('wrong')",
            1,
            "pgimp: rank 0: it broke",
        ),
    ],
)
def test_ranks_fail_together_with_one_message(mpirun, statement, status, message):
    done = mpirun(3, ["-c", FAILING.format(statement=statement)], timeout=30)
    assert done.returncode == status
    assert done.stderr.strip() == message
    assert "went on" not in done.stdout


def test_a_case_error_of_one_rank_ends_all(mpirun):
    script = FAILING.format(statement="if comm.rank == 1: raise CaseError('only here')")
    script = f"import pgimp.mpi.comm as c; c._AGREEMENT_SECONDS = 1.0\n{script}"
    done = mpirun(3, ["-c", script], timeout=30)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    mentions(line, "pgimp: ", "rank 1", "only here")


def test_a_run_that_succeeds_is_left_alone(mpirun):
    done = mpirun(3, ["-c", FAILING.format(statement="pass")])
    assert (done.returncode, done.stdout, done.stderr) == (0, "went on\n", "")


def test_on_one_rank_errors_pass_through():
    with pytest.raises(UsageError, match="mine"), abort_on_error(Serial()):
        raise UsageError("mine")


def test_abort_on_one_rank_leaves_with_the_status():
    with pytest.raises(SystemExit) as left:
        Serial().Abort(3)
    assert left.value.code == 3
