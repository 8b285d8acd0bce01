"""``pgimp init``: cases to start from, as in cases/, also from a wheel; the lines for editors."""

import json
import math
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from processes import run
from schema_checker import Checker

from pgimp.case.load import load
from pgimp.case.reader import read_case
from pgimp.cli import main
from pgimp.commands.init import packaged
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.scene import Scene
from pgimp.utilities.reference.jsonschema import json_schema, study_schema
from pgimp.utilities.study.plan import read_plan

pytestmark = pytest.mark.slow(30)

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "cases"
NAMES = [str(path.relative_to(CASES).with_suffix("")) for path in CASES.rglob("*.yaml")]
#: Those of fluid/ and own/ need files of Python, see tests/cases/test_dam_break.py, test_swirl.py.
ONLY_CASES = [name for name in NAMES if not name.startswith(("studies/", "fluid/", "own/"))]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_every_file_of_cases_is_listed_with_a_line(capsys):
    assert main(["init"]) == 0
    listed = capsys.readouterr().out.splitlines()[1:]
    assert sorted(line.split()[0] for line in listed) == sorted(NAMES)
    assert all(re.fullmatch(r"  [\w/-]+ +([123]D|study) +\w.*[^.]", line) for line in listed)
    plain = [line.split()[1] for line in listed if "/" not in line.split()[0]]
    assert plain == sorted(plain)
    assert set(plain) == {"1D", "2D", "3D"}


@pytest.mark.parametrize("name", ONLY_CASES)
def test_case_written_is_the_packaged_one_with_its_own_name(name, folder):
    assert main(["init", name]) == 0
    file = f"{Path(name).name}.yaml"
    assert set(files(folder)) - {"nut.obj"} == {file, "pgimp-schema.json"}
    text = (folder / file).read_text()
    assert text.startswith("# yaml-language-server: $schema=pgimp-schema.json\n# ")
    there = (CASES / f"{name}.yaml").read_text()
    assert read_case(text, file) == read_case(there, file)
    assert f"pgimp {file}" in text
    assert f"cases/{name}" not in text
    assert "scripts/run" not in text


@pytest.mark.parametrize("name", ONLY_CASES)
def test_editors_find_nothing_wrong_with_a_case(name):
    from ruamel.yaml import YAML

    assert Checker(json_schema())(YAML(typ="safe").load(packaged()[name]))


@pytest.mark.parametrize("name", ONLY_CASES)
def test_every_part_of_a_case_has_a_comment(name):
    opening, _, body = packaged()[name].partition("\nformat:")
    assert len(opening.splitlines()) > 10
    parts = re.split(r"\n(?=\w)", body)[1:]
    assert [part.split(":")[0] for part in parts if "#" not in part] == ["title"]


def test_mesh_comes_with_its_case(folder, capsys):
    assert main(["init", "geometry/nut", "-o", "mine.yaml"]) == 0
    assert set(files(folder)) == {"mine.yaml", "nut.obj", "pgimp-schema.json"}
    assert files(folder)["nut.obj"] == (CASES / "geometry/nut.obj").read_bytes()
    scene = Scene(load("mine.yaml"))
    lattice, counts, _ = count_particles(scene, Serial())
    planes = lattice.make((0, lattice.planes), counts, 0)
    volume = lattice.volume * sum(float(made.fractions.sum()) for made in planes)
    assert volume == pytest.approx(math.sqrt(3.0) / 2.0 * (13.0**2 - 8.0**2) * 6.5e-9, rel=1e-12)


def test_material_comes_with_its_case(folder, capsys):
    assert main(["init", "fluid/dam-break", "-o", "my dam.yaml"]) == 0
    assert set(files(folder)) == {"my dam.yaml", "fluid.py", "pgimp-schema.json"}
    assert files(folder)["fluid.py"] == (CASES / "fluid.py").read_bytes()
    words = "'my dam.yaml' --import fluid.py"
    assert f"mpirun -n 2 pgimp {words} " in capsys.readouterr().out
    text = (folder / "my dam.yaml").read_text()
    assert f"mpirun -n 2 pgimp {words}\n" in text and "/fluid.py" not in text
    short = ["--set", "time.end=0.01", "--quiet"]
    done = run([sys.executable, "-m", "pgimp", *shlex.split(words), *short], cwd=folder)
    assert done.returncode == 0, done.stderr


def test_a_file_of_that_name_is_left_alone(folder, capsys):
    (folder / "fluid.py").write_text("mine")
    assert main(["init", "fluid/dam-break"]) == 0
    assert "fluid.py: there already, and left alone" in capsys.readouterr().out
    assert (folder / "fluid.py").read_text() == "mine"


def test_nothing_is_overwritten(folder, capsys):
    (folder / "disks.yaml").write_text("mine")
    assert main(["init", "disks"]) == 2
    assert "disks.yaml is there already, and stays as it is" in capsys.readouterr().err
    assert files(folder) == {"disks.yaml": b"mine"}

    (folder / "pgimp-schema.json").write_text("{}")
    assert main(["init", "disks", "-o", "new.yaml"]) == 0
    said = capsys.readouterr().out
    assert "to renew it: pgimp schema > pgimp-schema.json" in said
    assert set(files(folder)) == {"disks.yaml", "new.yaml", "pgimp-schema.json"}
    assert (folder / "disks.yaml").read_text() == "mine"
    assert (folder / "pgimp-schema.json").read_text() == "{}"
    assert "mpirun -n 2 pgimp new.yaml" in (folder / "new.yaml").read_text()


def test_study_comes_with_its_case(folder, capsys):
    assert main(["init", "studies/compaction"]) == 0
    schemas = {"pgimp-schema.json", "pgimp-study-schema.json"}
    assert set(files(folder)) == {"compaction-study.yaml", "compaction.yaml"} | schemas
    plan, there = (
        read_plan(path)
        for path in (folder / "compaction-study.yaml", CASES / "studies/compaction.yaml")
    )
    assert {one.name for one in plan.runs} == {one.name for one in there.runs}
    from ruamel.yaml import YAML

    text = (folder / "compaction-study.yaml").read_text()
    assert Checker(study_schema())(YAML(typ="safe").load(text))
    before = files(folder)
    assert main(["init", "studies/compaction"]) == 2
    assert main(["init", "studies/compaction", "-o", "compaction.yaml"]) == 2
    assert files(folder) == before


def test_the_accuracy_of_a_case(folder, capsys):
    """Of the one that comes with it, and of one's own; the file's name does for the folder's."""
    assert main(["init", "accuracy"]) == 0
    assert {"accuracy-study.yaml", "bar-vibration.yaml"} < set(files(folder))
    assert len(read_plan(folder / "accuracy-study.yaml").runs) == 3
    assert main(["init", "disks"]) == 0
    assert main(["init", "accuracy", "--case", "disks.yaml"]) == 0
    plan = read_plan(folder / "disks-accuracy.yaml")
    assert [one.x for one in plan.runs] == [0.08, 0.04, 0.02]
    before = files(folder)
    assert main(["init", "accuracy", "--case", "disks.yaml"]) == 2
    assert main(["init", "vortex", "--case", "disks.yaml"]) == 2
    assert main(["init", "accuracy", "--case", "nowhere.yaml"]) == 2
    assert files(folder) == before


def test_study_keeps_a_case_of_its_owner(folder, capsys):
    (folder / "compaction.yaml").write_text("mine")
    assert main(["init", "studies/compaction"]) == 0
    assert "compaction.yaml: there already, and left alone" in capsys.readouterr().out
    assert (folder / "compaction.yaml").read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["disk"], "there is no case 'disk' to start from. Did you mean disks?"),
        (["stretch"], "Did you mean hard/stretch?"),
        (["../README"], "there is no case '../README' to start from"),
        (["disks", "-o", "nowhere/disks.yaml"], "cannot write nowhere/disks.yaml: No such file"),
        (["-o", "disks.yaml"], "which case is to be written?"),
    ],
)
def test_wrong_names(folder, capsys, words, said):
    assert main(["init", *words]) == 2
    assert said in capsys.readouterr().err
    assert files(folder) == {}


def test_schema_command_writes_what_init_writes(folder, capsys):
    assert main(["init", "disks"]) == 0
    capsys.readouterr()
    assert main(["schema"]) == 0
    assert (folder / "pgimp-schema.json").read_text() == capsys.readouterr().out
    assert json.loads((folder / "pgimp-schema.json").read_text())["title"] == "pgimp case file"


def test_every_case_passes_check(folder):
    """Scene by scene, as `pgimp check` begins; the whole command on one of them."""
    for name in ONLY_CASES:
        _, counts, _ = count_particles(Scene(load(CASES / f"{name}.yaml")), Serial())
        assert counts.sum() > 0
    assert main(["init", "bar-vibration"]) == 0
    done = run([sys.executable, "-m", "pgimp", "check", "bar-vibration.yaml"], cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "warning" not in done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder into which a wheel of pgimp is unpacked, as pip does."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    source.mkdir()
    words = ["cp", "-r", "pgimp", "cases", "pyproject.toml", "README.md", "LICENSE", str(source)]
    subprocess.run(words, cwd=ROOT, check=True, timeout=60)
    pip = [sys.executable, "-m", "pip", "-qq", "--disable-pip-version-check"]
    wheel = ["wheel", "--no-deps", "--no-build-isolation", "-w", str(folder), str(source)]
    done = run([*pip, *wheel])
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    done = run([*pip, "install", "--no-deps", "--target", str(folder / "target"), str(path)])
    assert done.returncode == 0, done.stderr
    return folder / "target"


@pytest.mark.wide
def test_init_works_from_a_wheel(installed, folder):
    env = {"PYTHONPATH": str(installed)}
    script = (
        "import pgimp, sys; from pgimp.cli import main; print(pgimp.__file__); sys.exit(main())"
    )
    done = run([sys.executable, "-c", script, "init"], cwd=folder, env=env)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{installed}{os.sep}")
    assert {line.split()[0] for line in done.stdout.splitlines()[2:]} == set(NAMES)
    for name in ("block3d", "geometry/nut", "fluid/dam-break"):
        done = run([sys.executable, "-c", script, "init", name], cwd=folder, env=env)
        assert done.returncode == 0, done.stderr
    written, there = ((at / "block3d.yaml").read_text() for at in (folder, CASES))
    assert read_case(written) == read_case(there)
    assert {"nut.obj", "dam-break.yaml", "fluid.py"} <= set(files(folder))
    words = "batch block3d.yaml --ranks 2 --wall-time 1:00:00 --script -".split()
    done = run([sys.executable, "-c", script, *words], cwd=folder, env=env)
    assert "#SBATCH --ntasks=2\n" in done.stdout, done.stderr
