"""README.md and the pages of docs/, and the blocks of code in them."""

import os
import re
import sys
from pathlib import Path

from ruamel.yaml import YAML

ROOT = Path(__file__).resolve().parents[3]
DOCS = ROOT / "docs"
CONFIGURATION = ROOT / "scripts" / "pages" / "mkdocs.yml"


def listed_pages(entry):
    """File names of the pages of the site, in the order of its navigation."""
    if isinstance(entry, str):
        return [entry]
    values = entry.values() if isinstance(entry, dict) else entry
    return [name for value in values for name in listed_pages(value)]


NAVIGATION = listed_pages(YAML(typ="safe").load(CONFIGURATION)["nav"])
#: README.md and the pages, in the order in which they are read, and their commands run.
PAGES = {"README.md": (ROOT / "README.md").read_text(encoding="utf-8")} | {
    f"docs/{name}": (DOCS / name).read_text(encoding="utf-8")
    for name in NAVIGATION
    if not name.startswith(("cases/", "tutorials/"))
}
#: Pages that are followed in folders of their own (`tutorials.follow`).
TUTORIALS = {
    f"docs/{name}": (DOCS / name).read_text(encoding="utf-8")
    for name in NAVIGATION
    if name.startswith("tutorials/")
}
#: Those, and what they link to.
LINKED = (
    PAGES
    | TUTORIALS
    | {
        name: (ROOT / name).read_text(encoding="utf-8")
        for name in ("cases/README.md", "cases/reference.md", "CHANGELOG.md")
    }
)
TEXT = "\n".join(PAGES.values())
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
BLOCKS = FENCE.findall(TEXT)
ACTIVATE = ". .venv/bin/activate"
# Root may use mpirun, and more ranks than cores, also where the command does not say so.
ENVIRONMENT = {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}


def blocks(language):
    return [text for kind, text in BLOCKS if kind == language]


def block_of(beginning):
    """The only block of code that begins like this."""
    (found,) = [text for _, text in BLOCKS if text.startswith(beginning)]
    return found


def apply(difference, path):
    """Apply a difference printed without line numbers: its old lines must be there, once."""
    lines = difference.splitlines(keepends=True)
    old = "".join(line[1:] for line in lines if line[0] in " -")
    new = "".join(line[1:] for line in lines if line[0] in " +")
    text = path.read_text()
    assert text.count(old) == 1, f"{path.name} has changed: {old}"
    path.write_text(text.replace(old, new))
