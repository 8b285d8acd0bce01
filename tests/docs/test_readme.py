"""README.md and docs/ keep their word: commands, cases and programs work as printed."""

import re
import shlex
import shutil
import sys

import pytest
from pages import (
    ACTIVATE,
    BLOCKS,
    DOCS,
    ENVIRONMENT,
    FENCE,
    LINKED,
    NAVIGATION,
    PAGES,
    ROOT,
    TEXT,
    block_of,
    blocks,
)
from processes import run

import pgimp

pytestmark = pytest.mark.slow(40)

#: Pages that everybody follows.
FIRST = ("README.md", "docs/first-steps.md")
SHORT = "--set time.end=0.004 --set output.every=null --quiet"
INSTEAD = {
    "pgimp study cases/studies/compaction.yaml": "pgimp study cases/studies/compaction.yaml --list",
    "scripts/test": f"{ROOT}/scripts/test --version",  # this test is one of those it would run
    "scripts/test --fast": f"{ROOT}/scripts/test --version",
    "scripts/test tests/kernels/test_bits.py -k order": f"{ROOT}/scripts/test --version",
    "scripts/setup --test": f"{ROOT}/scripts/setup --help",
    "scripts/docs": f"{ROOT}/scripts/docs --help",  # see tests/docs/test_docs.py
    "sbatch block3d.sh": "bash -n block3d.sh",
    "pgimp bench": "pgimp bench --cells 4 --repeats 1",
    "pgimp schema '>' pgimp-schema.json": "pgimp schema",  # no shell here
    "mpirun -n 2 pgimp --import cases/fluid.py my-case.yaml": "mpirun -n 2 pgimp --import "
    "cases/fluid.py cases/disks.yaml -o fluid.out --set "
    "'materials.jelly={model: fluid, bulk: 1.0e3, shear: 0.1, density: 1.0e3}' "
    "--set contact=[] --set time.end=0.004 --quiet",
    "mpirun -n 2 pgimp case.yaml --import wind.py": "mpirun -n 2 pgimp cases/own/swirl.yaml "
    "--import cases/swirl.py -o swirl.out --set time.end=0.01 --quiet",
    "pgimp study cases/studies/swirl.yaml --import cases/swirl.py": "pgimp study "
    "cases/studies/swirl.yaml --import cases/swirl.py --list",
    "pgimp cases/taylor-axisymmetric.yaml -o taylor.out": "pgimp cases/taylor-axisymmetric.yaml "
    "-o taylor.out --set time.end=2.0e-6 --set output.every=null --quiet",
    "pgimp plot run.out --columns gauge.waist.force-x": "pgimp plot block3d.out --columns mass",
    # The run has been too short for the times of the text.
    "pgimp plot block3d.out --field von-mises --time 0,0.32,0.46,0.6": "pgimp plot block3d.out "
    "--field von-mises --frame 0,-1",
    # Into a folder of its own, with what this environment has already.
    "pip install .": "python -m pip install -qq --no-deps --no-build-isolation --target installed "
    "./source",
}


def commands(text):
    """The commands of all shell blocks of pages, in order, without comments, each once."""
    found = [block for kind, block in FENCE.findall(text) if kind == "sh"]
    lines = [shlex.join(shlex.split(line, comments=True)) for line in "".join(found).splitlines()]
    return list(dict.fromkeys(line for line in lines if line and line != ACTIVATE))


def shortened(command):
    """What is run for a command: a few steps of a case, a small benchmark."""
    if command in INSTEAD:
        return INSTEAD[command]
    if re.match(r"(mpirun -n \d+ )?pgimp cases/|scripts/run ", command):
        return f"{command} {SHORT}".replace("scripts/run", f"{ROOT}/scripts/run")
    return command


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the cases, in which the commands of the pages run."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "cases").symlink_to(ROOT / "cases")
    source = folder / "source"
    source.mkdir()
    shutil.copytree(ROOT / "pgimp", source / "pgimp", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    return folder


def test_every_page_is_in_the_navigation():
    there = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")}
    assert there | {"cases/README.md", "cases/reference.md"} == set(NAVIGATION)
    assert len(NAVIGATION) == len(set(NAVIGATION))


def test_readme_is_short_and_says_first_what_cannot_be_done():
    lines = PAGES["README.md"].splitlines()
    assert len(lines) <= 150
    assert any("What it cannot do" in line for line in lines[:12])
    assert max(map(len, FENCE.sub("", PAGES["README.md"]).splitlines())) < 140


def test_commands_are_in_blocks_that_are_run():
    """What stands in a block of `text` is for a cluster or a home folder, or what pgimp prints."""
    assert {language for language, _ in BLOCKS} <= {"sh", "yaml", "python", "diff", "text"}
    completion = "pgimp completion bash > ~/.local/share/bash-completion/completions/pgimp"
    first = [text.splitlines()[0].split("  ")[0] for text in blocks("text")]
    assert first == [completion, "a step", "module load openmpi"]
    for name, text in PAGES.items():
        outside = FENCE.sub("", text)
        assert "```" not in outside, name
        assert not re.search(r"^    (mpirun|pgimp|scripts/|pip|python) ", outside, re.M), name


def check_notebook(output, done, ranks):
    """What cases/notebook.py leaves and says: errors fall with the cells, the water rises."""
    assert done.stdout.count("the water is at") == 4 and "stress-xx" not in done.stderr
    assert (output / "notebook.png").stat().st_size > 10_000
    errors = [pgimp.open(output / f"{h}").history["error"][-1] for h in (5.0, 2.5, 1.0)]
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2] > 0.0
    assert pgimp.open(output / "column").info["ranks"] == ranks


@pytest.mark.parametrize(
    ("text", "least"),
    [
        pytest.param("\n".join(map(PAGES.get, FIRST)), 8, id="first"),
        pytest.param(TEXT, 31, id="all", marks=pytest.mark.wide),
    ],
)
def test_commands_run(folder, display, text, least):
    """Every command of the shell blocks, in order, in one folder."""
    listed = commands(text)
    assert listed[:2] == ["scripts/run cases/block3d.yaml", "scripts/test"]
    assert len(listed) >= least
    started = set()
    # Some are shortened to the same.
    for command in dict.fromkeys(map(shortened, listed)):
        words = shlex.split(command)
        if words[-1] == "--quiet" and "-o" not in words:
            output = re.search(r"cases/([\w-]+)\.yaml", command)[1]
            if (
                output in started and "--resume" not in words
            ):  # the text's reader would add it, or has removed the other
                words.append("--overwrite")
            started.add(output)
        done = run(words, cwd=folder, env=ENVIRONMENT | display)
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
        if words[-1] == "cases/notebook.py":
            check_notebook(folder / "notebook.out", done, 2 if "mpirun" in words else 1)
    assert (folder / "installed" / "pgimp" / "__main__.py").is_file()


def test_python_example_runs(folder):
    done = run([sys.executable, "-c", block_of("import pgimp\n")], cwd=folder, env=ENVIRONMENT)
    assert done.returncode == 0, done.stderr
    errors = [float(line.split()[1]) for line in done.stdout.splitlines()]
    assert len(errors) == 3 and errors == sorted(errors, reverse=True)  # finer is better


@pytest.mark.wide
def test_ground_at_rest_stays_at_rest(folder):
    program = block_of("import numpy as np\n\nimport pgimp\n\nground")
    done = run([sys.executable, "-c", program], cwd=folder, env=ENVIRONMENT)
    assert done.returncode == 0, done.stderr


def anchors(text):
    """Anchors of the headings of a page, as code hosts and the site make them."""
    titles = re.findall(r"^#+ (.+)$", FENCE.sub("", text), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).strip().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("name", LINKED)
def test_links_lead_somewhere(name):
    """To files that are there, and to headings that they have."""
    folder = (ROOT / name).parent
    for target, _, anchor in (
        link.partition("#") for link in re.findall(r"\]\(([^)\s]+)\)", FENCE.sub("", LINKED[name]))
    ):
        if "://" in target:
            continue
        path = (folder / target).resolve() if target else ROOT / name
        assert path.exists(), f"{name}: {target}"
        if anchor:
            assert anchor in anchors(path.read_text(encoding="utf-8")), f"{name}: #{anchor}"


def test_pages_are_linked_from_the_readme():
    for name in NAVIGATION:
        if name not in ("index.md", "cases/README.md", "cases/reference.md"):
            assert f"](docs/{name})" in PAGES["README.md"], name
            assert f"]({name})" in PAGES["docs/index.md"], name


def test_pictures_are_small_and_shown():
    assert "(../cases/pictures/error-and-cost.png)" in PAGES["docs/convergence.md"]
    for picture in (ROOT / "cases" / "pictures").iterdir():
        assert picture.stat().st_size < 150_000, picture.name
        assert any(picture.name in text for text in LINKED.values()), picture.name


def test_options_and_commands_named_exist(python):
    """Each command in a table is in the help, and so is each option of a run."""
    text = python(["-m", "pgimp", "--help"]).stdout
    commands = re.findall(r"^\| `pgimp (\w+)", TEXT, re.MULTILINE)
    assert len(commands) >= 9
    for command in commands:
        assert f"  {command} " in text
    page = PAGES["docs/running.md"]
    options = re.findall(r"`(-o|--[\w-]+)(?: [\w.=:]+)?`", page.partition("## Commands")[0])
    assert len(options) >= 6
    for option in options:
        assert option in text
