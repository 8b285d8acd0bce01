"""The command line: what it answers once for all ranks, what it says of wrong words."""

from importlib.metadata import version

import pytest

from pgimp.cli import COMMANDS, main

TRACEBACK_HINT = "(set PGIMP_TRACEBACK=1 for the traceback)"


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["comapre"], 2, "Did you mean"),
        ([], 2, "which case?"),
        (["--help"], 0, "usage: pgimp CASE.yaml [options]"),
        (["--version"], 0, f"pgimp {version('pgimp')}"),
        (["doctor", "--help"], 0, "usage: pgimp doctor"),
        (["compare", "--bogus"], 2, "usage: pgimp compare"),
    ],
)
def test_several_ranks_answer_once(mpirun, words, status, said):
    done = mpirun(3, ["-m", "pgimp", *words], timeout=30)
    assert done.returncode == status
    assert (done.stdout + done.stderr).count(said) == 1


def test_a_first_rank_that_is_late_still_answers(mpirun, tmp_path):
    """Open MPI kills it when another one has ended with an error before: that one has to wait."""
    late = 'import os, time\nif os.environ.get("OMPI_COMM_WORLD_RANK") == "0": time.sleep(0.3)\n'
    (tmp_path / "sitecustomize.py").write_text(late, encoding="utf-8")
    done = mpirun(3, ["-m", "pgimp"], timeout=30, env={"PYTHONPATH": str(tmp_path)})
    assert done.returncode == 2
    assert done.stderr.count("which case?") == 1


def test_no_arguments_explains_itself(capsys):
    assert main([]) == 2
    said = capsys.readouterr().err
    assert "pgimp CASE.yaml" in said
    assert all(f"  {name} " in said for name in COMMANDS)


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text("format: 1\n")
    return path


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["comapre"], "Did you mean `pgimp compare`?"),
        (["case.yml"], "there is no case file case.yml. Did you mean case.yaml?"),
        (["nowhere/case.yaml"], "there is no case file nowhere/case.yaml."),
        (["."], "is a directory"),
        (["--quiet", "check"], "the command must be the first word: pgimp check"),
        (["case.yaml", "--overwite"], "unrecognized arguments: --overwite"),
        (["-o"], "expected one argument"),
        (["chekc", "x"], "there is no command chekc. Did you mean `pgimp check x`?"),
        (["run", "case.yaml"], "a case is run with `pgimp case.yaml`"),
        (["run"], "there is no command run: a case is run with `pgimp CASE.yaml`. Which case?"),
        (["-n", "4", "case.yaml"], "for the launcher: `mpirun -n 4 pgimp case.yaml`"),
        (["case.yaml", "-np", "4", "--quiet"], "`mpirun -n 4 pgimp case.yaml --quiet`"),
        (["-n4", "case.yaml"], "`mpirun -n 4 pgimp case.yaml`"),
        (["case.yaml", "-n"], "unrecognized arguments: -n"),
        (["doctor", "--bogus"], "unrecognized arguments: --bogus"),
    ],
)
def test_wrong_command_lines(monkeypatch, capsys, case, words, said):
    monkeypatch.chdir(case.parent)
    assert main(words) == 2
    out, err = capsys.readouterr()
    assert said in err
    assert err.startswith("pgimp: ")
    assert out == ""


def test_version_imports_nothing_of_a_run(python):
    program = "import sys; from pgimp.cli import main; main(sys.argv[1:]); print(*sys.modules)"
    imported = {*python(["-c", program, "--version"]).stdout.split()}
    assert "pgimp.cli" in imported
    assert not imported & {"numpy", "numba", "pydantic", "h5py", "mpi4py", "ruamel.yaml"}


def test_version_needs_no_case(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"pgimp {version('pgimp')}\n"


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (BrokenPipeError(), 1, f"pgimp: unexpected BrokenPipeError {TRACEBACK_HINT}\n"),
        (KeyboardInterrupt(), 130, "pgimp: interrupted\n"),
        (MemoryError(), 1, "pgimp: out of memory\n"),
        (KeyError("x"), 1, f"pgimp: unexpected KeyError: 'x' {TRACEBACK_HINT}\n"),
    ],
)
def test_what_a_command_raises_becomes_a_status(python, error, status, said):
    script = f"""
import sys, pgimp.cli, pgimp.commands.doctor as doctor
def execute(args): raise {error!r}
doctor.execute = execute
sys.exit(pgimp.cli.main(["doctor"]))
"""
    done = python(["-c", script])
    assert (done.returncode, done.stderr) == (status, said)


def test_traceback_on_request(python):
    script = """
import sys, pgimp.cli, pgimp.commands.doctor as doctor
def execute(args): raise KeyError("x")
doctor.execute = execute
sys.exit(pgimp.cli.main(["doctor"]))
"""
    done = python(["-c", script], env={"PGIMP_TRACEBACK": "1"})
    assert done.returncode == 1
    assert "Traceback" in done.stderr
