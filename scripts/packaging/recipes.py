"""What the recipes require, read from them as text: nothing of conda, Spack or EasyBuild is needed.

A bound is a pair of versions: from the first one on, and below the second one, as tuples.
"""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

from ruamel.yaml import YAML

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
Version = tuple[int, ...]
Bound = tuple[Version, Version | None]

CONDA = HERE / "conda" / "recipe.yaml"
SPACK = HERE / "spack" / "spack_repo" / "pgimp" / "packages" / "pgimp" / "package.py"
(EASYBUILD,) = (HERE / "easybuild").glob("pgimp-*.eb")
#: Names of what conda and Spack call otherwise.
_OTHERWISE = {"matplotlib-base": "matplotlib", "ruamel-yaml": "ruamel.yaml"}


def version_of(text: str) -> Version:
    """Return the numbers of a version."""
    return tuple(map(int, text.split(".")))


def project() -> dict:
    """Return the table ``project`` of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def required() -> dict[str, Bound]:
    """Return the requirements of pyproject.toml."""
    return dict(_requirement(text) for text in project()["dependencies"])


def _requirement(text: str) -> tuple[str, Bound]:
    name, least, _, below = re.fullmatch(r"([\w.-]+) ?>=([\d.]+)(,<([\d.]+))?", text).groups()
    return name, (version_of(least), version_of(below) if below else None)


def conda() -> dict[str, Bound]:
    """Return what the conda recipe's ``run`` has with bounds; a build's name is left out."""
    run = YAML(typ="safe").load(CONDA)["requirements"]["run"]
    bound = (re.sub(r" mpi_\S+$", "", text) for text in run if "python_min" not in text)
    found = dict(_requirement(text) for text in bound if ">=" in text)
    return {_OTHERWISE.get(name, name): limits for name, limits in found.items()}


def spack() -> dict[str, Bound]:
    """Return what the Spack recipe depends on with bounds, but for Python.

    Spack's upper end is included with all that begins like it: ``:3`` is below 4.
    """
    found = {}
    for node in ast.walk(ast.parse(SPACK.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "depends_on":
            text = ast.literal_eval(node.args[0])
            match = re.match(r"py-([\w-]+)@([\d.]+):([\d.]+)", text)
            if match:
                *first, last = version_of(match[3])
                name = _OTHERWISE.get(match[1], match[1])
                found[name] = version_of(match[2]), (*first, last + 1)
    return found


def easybuild() -> dict[str, object]:
    """Return the variables of the EasyBuild recipe."""
    tree = ast.parse(EASYBUILD.read_text(encoding="utf-8"))
    return {
        node.targets[0].id: ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign)
    }


def versions() -> dict[str, str]:
    """Return the version of pgimp that each file names, by path."""
    found = {"pyproject.toml": project()["version"]}
    patterns = {
        ROOT / "CITATION.cff": r"^version: (\S+)",
        CONDA: r'^  version: "(\S+)"',
        SPACK: r'^    version\("([\d.]+)"',
        EASYBUILD: r"^version = '(\S+)'",
    }
    for path, pattern in patterns.items():
        match = re.search(pattern, path.read_text(encoding="utf-8"), re.MULTILINE)
        found[str(path.relative_to(ROOT))] = match[1] if match else ""
    found[EASYBUILD.name] = EASYBUILD.name.split("-")[1]
    return found
