"""README.md keeps its word: its commands, case and material work as printed."""

import ast
import inspect
import os
import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest
from conftest import run

from pgimp.case.reader import read_case
from pgimp.jit import algebra
from pgimp.tools.study.plan import read_plan

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
ACTIVATE = ". .venv/bin/activate"
# Root may use mpirun, and more ranks than cores, also where the command does not say so.
ENVIRONMENT = {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
SHORT = "--set time.end=0.004 --set output.every=null --quiet"
INSTEAD = {
    "pgimp study cases/studies/compaction.yaml": "pgimp study cases/studies/compaction.yaml --list",
    "scripts/test": f"{ROOT}/scripts/test --version",  # this test is one of those it would run
    "sbatch block3d.sh": "bash -n block3d.sh",
    "pgimp bench": "pgimp bench --cells 4 --repeats 1",
    "pgimp schema '>' pgimp-schema.json": "pgimp schema",  # no shell here
    "mpirun -n 2 pgimp --import cases/fluid.py my-case.yaml": "mpirun -n 2 pgimp --import "
    "cases/fluid.py cases/disks.yaml -o fluid.out --set "
    "'materials.jelly={model: fluid, bulk: 1.0e3, shear: 0.1, density: 1.0e3}' "
    "--set time.end=0.004 --quiet",
    # The run has been too short for the times of the text.
    "pgimp plot block3d.out --field von-mises --time 0,0.32,0.46,0.6": "pgimp plot block3d.out "
    "--field von-mises --frame 0,-1",
    # Into a folder of its own, with what this environment has already.
    "pip install .": "python -m pip install -qq --no-deps --no-build-isolation --target installed "
    "./source",
}


def blocks(language):
    return [text for kind, text in BLOCKS if kind == language]


def block_of(beginning):
    """The only block of code that begins like this."""
    (found,) = [text for _, text in BLOCKS if text.startswith(beginning)]
    return found


def commands():
    """The commands of all shell blocks, in order, without comments."""
    lines = [
        shlex.join(shlex.split(line, comments=True)) for line in "".join(blocks("sh")).splitlines()
    ]
    return [line for line in lines if line and line != ACTIVATE]


def shortened(command):
    """What is run for a command: a few steps of a case, a small benchmark."""
    if command in INSTEAD:
        return INSTEAD[command]
    if re.match(r"(mpirun -n \d+ )?pgimp cases/|scripts/run ", command):
        return f"{command} {SHORT}".replace("scripts/run", f"{ROOT}/scripts/run")
    return command


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the cases, in which the commands of README.md run."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "cases").symlink_to(ROOT / "cases")
    source = folder / "source"
    source.mkdir()
    shutil.copytree(ROOT / "pgimp", source / "pgimp", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    return folder


def test_commands_run(folder, display):
    """Every command of the shell blocks, in order, in one folder."""
    listed = commands()
    assert listed[:2] == ["scripts/run cases/block3d.yaml", "scripts/test"]
    assert len(listed) > 10
    started = set()
    for command in listed:
        words = shlex.split(shortened(command))
        if words[-1] == "--quiet" and "-o" not in words:
            output = re.search(r"cases/([\w-]+)\.yaml", command)[1]
            if (
                output in started and "--resume" not in words
            ):  # the text's reader would add it, or has removed the other
                words.append("--overwrite")
            started.add(output)
        done = run(words, cwd=folder, env=ENVIRONMENT | display)
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    assert (folder / "installed" / "pgimp" / "__main__.py").is_file()


def test_first_case_is_printed_as_it_is():
    printed = read_case(block_of("format: 1\ntitle"), "README.md", [])
    there = (ROOT / "cases/block3d.yaml").read_text(encoding="utf-8")
    assert printed == read_case(there, "block3d.yaml", [])


def test_the_study_is_one(tmp_path):
    """It is a part of the study in cases/studies."""
    text = block_of("format: 1\ncase: ")
    path = tmp_path / "printed.yaml"
    path.write_text(text.replace("../compaction.yaml", str(ROOT / "cases/compaction.yaml")))
    there = read_plan(ROOT / "cases/studies/compaction.yaml").runs
    assert {run.name for run in read_plan(path).runs} < {run.name for run in there}


def test_python_example_runs(folder):
    done = run([sys.executable, "-c", block_of("import pgimp\n")], cwd=folder, env=ENVIRONMENT)
    assert done.returncode == 0, done.stderr
    errors = [float(line.split()[1]) for line in done.stdout.splitlines()]
    assert len(errors) == 3 and errors == sorted(errors, reverse=True)  # finer is better


def test_material_of_ones_own_is_printed_as_it_is():
    """But for its docstrings, `cases/fluid.py`."""

    def code(text):
        tree = ast.parse(text)
        for node in ast.walk(tree):
            body = getattr(node, "body", None)
            if isinstance(body, list) and ast.get_docstring(node) is not None:
                del body[0]
            if isinstance(node, ast.FunctionDef):
                node.returns = None
        return ast.unparse(tree)

    text = (ROOT / "cases/fluid.py").read_text(encoding="utf-8")
    assert code(block_of("from math import log, sqrt\nfrom typing")) == code(text)


def test_all_operations_on_tensors_are_listed():
    """Each function of `pgimp.jit.algebra` with its arguments, and no other."""
    table = TEXT.partition("| operation | result |\n|---|---|\n")[2].partition("\n\n")[0]
    listed = re.findall(r"^\| `(.*?)`", table, re.MULTILINE)
    there = [
        f"{name}{inspect.signature(function)}"
        for name, function in vars(algebra).items()
        if inspect.isfunction(function) and function.__module__ == algebra.__name__
        if not name.startswith("_")
    ]
    assert listed == there


def apply(difference, path):
    """Apply a difference printed without line numbers: its old lines must be there, once."""
    lines = difference.splitlines(keepends=True)
    old = "".join(line[1:] for line in lines if line[0] in " -")
    new = "".join(line[1:] for line in lines if line[0] in " +")
    text = path.read_text()
    assert text.count(old) == 1, f"{path.name} has changed: {old}"
    path.write_text(text.replace(old, new))


def test_material_works_as_printed(folder):
    """The file, the registration and the test of README.md, in a copy of the package."""
    package, tests = folder / "source" / "pgimp", folder / "source" / "tests"
    (package / "materials" / "fluid.py").write_text(block_of('"""Slightly compressible'))
    differences = blocks("diff")
    assert len(differences) == 2
    for difference in differences:
        apply(difference, package / "materials" / "__init__.py")
    shutil.copytree(ROOT / "tests", tests, ignore=shutil.ignore_patterns("__pycache__"))
    (tests / "test_fluid.py").write_text(block_of('"""The fluid'))
    source = folder / "source"
    env = ENVIRONMENT | {"PYTHONPATH": str(source), "PGIMP_CACHE_DIR": str(folder / "cache")}
    tested = run([sys.executable, "-m", "pytest", "tests/test_fluid.py"], 100, source, env)
    assert tested.returncode == 0, tested.stdout
    assert "5 passed" in tested.stdout
    water = "materials.jelly={model: fluid, bulk: 1.0e3, shear_viscosity: 1.0, density: 1.0e3}"
    ruff = ["-m", "ruff", "check", "pgimp/physics/materials", "tests/test_fluid.py"]
    style = run([sys.executable, *ruff], cwd=source)
    assert style.returncode == 0, style.stdout
    words = [sys.executable, "-m", "pgimp", "cases/disks.yaml", "-o", "water.out"]
    done = run([*words, "--set", water, "--set", "time.end=0.05"], 100, folder, env)
    assert done.returncode == 0, done.stderr


def test_links_and_pictures_exist():
    targets = [name for name in re.findall(r"\]\(([^)#]+)\)", TEXT) if "://" not in name]
    assert "cases/pictures/error-and-cost.png" in targets
    for target in targets:
        assert (ROOT / target).exists(), target
    for picture in (ROOT / "cases" / "pictures").iterdir():
        assert picture.stat().st_size < 150_000, picture.name


def test_options_and_commands_named_exist(python):
    """Each command in a table is in the help, and so is each option of a run."""
    text = python(["-m", "pgimp", "--help"]).stdout
    for command in re.findall(r"^\| `pgimp (\w+)", TEXT, re.MULTILINE):
        assert f"  {command} " in text
    for option in re.findall(r"`(-o|--[\w-]+)(?: [\w.=]+)?`", TEXT.partition("| command")[0]):
        assert option in text
