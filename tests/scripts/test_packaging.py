"""The recipes of packages: versions and requirements are those of pyproject.toml."""

import ast
import re
import runpy

import pytest
import recipes

#: Versions that foss-2025b bundles: of numpy in SciPy-bundle, of rich in Python-bundle-PyPI.
BUNDLED = {"numpy": "2.3.2", "rich": "14.1.0"}


def test_all_name_one_version():
    assert set(recipes.versions().values()) == {recipes.project()["version"]}


def test_conda_requires_the_same():
    assert recipes.conda() == recipes.required()


def test_spack_requires_the_same():
    assert recipes.spack() == recipes.required()


def test_easybuild_has_versions_that_fit():
    there = dict(recipes.easybuild()["dependencies"]) | BUNDLED
    for name, (least, below) in recipes.required().items():
        assert least <= recipes.version_of(there[name]) < below, name
    assert set(there) - set(recipes.required()) == {
        "Python", "Python-bundle-PyPI", "SciPy-bundle"
    }  # fmt: skip


def test_python_is_as_old_as_the_project_allows():
    least = recipes.project()["requires-python"].removeprefix(">=")
    assert f'"{least}"' in (recipes.HERE / "conda" / "variants.yaml").read_text()
    assert f'depends_on("python@{least}:")' in recipes.SPACK.read_text()
    assert dict(recipes.easybuild()["dependencies"])["Python"] >= least


def test_h5py_has_the_mpi_of_mpi4py():
    """Or none: a second MPI in a process breaks both."""
    assert "h5py >=3.12,<4 mpi_openmpi*" in recipes.CONDA.read_text()
    assert "    - openmpi\n" in recipes.CONDA.read_text()
    assert re.search(r"py-h5py@\S+\+mpi", recipes.SPACK.read_text())
    assert recipes.easybuild()["toolchain"]["name"] == "foss"


@pytest.mark.parametrize("path", sorted(recipes.HERE.glob("spack/**/package.py")))
def test_spack_recipes_are_python(path):
    ast.parse(path.read_text())


def test_both_containers_do_the_same():
    """The commands of the Dockerfile's two installations are those of Apptainer's %post."""
    folder = recipes.HERE / "containers"
    docker = (folder / "Dockerfile").read_text()
    steps = re.findall(r"^RUN ((?:.*\\\n)*.*)", docker, re.MULTILINE)[:2]
    commands = [one.strip() for step in steps for one in step.replace("\\\n", "").split("&&")]
    post = (folder / "apptainer.def").read_text().partition("%post\n")[2].partition("\n\n")[0]
    assert [line.strip() for line in post.splitlines()] == ["set -e", *commands]
    base = re.search(r"^FROM (\S+)", docker, re.MULTILINE)[1]
    assert f"From: {base}\n" in (folder / "apptainer.def").read_text()


def test_a_tag_is_that_of_the_version(capsys):
    """scripts/release --tag hands it the tags of the commit."""
    program = runpy.run_path(str(recipes.HERE / "__main__.py"))["main"]
    version = recipes.project()["version"]
    assert program(["nightly", f"v{version}"]) == 0
    assert capsys.readouterr().out == f"{version}\n"
    assert program(["v0.0.9"]) == 1
    assert f"no tag v{version}, but v0.0.9" in capsys.readouterr().out
