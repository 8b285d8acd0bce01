"""What a case says of itself: its header, its row in cases/README.md, and its picture there."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from ruamel.yaml import YAML

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "cases"
STUDIES = "studies"

_PART = re.compile(r"(\w+)   +(\S.*)")
_OTHER_WAY = re.compile(r"\s*\(or: .*")
_ROW = re.compile(r"^\| \[[\w-]+\]\(([\w/-]+)\.yaml\) \|(.*)\|$", re.MULTILINE)
#: The end of a row's physics, behind the number of dimensions: what the case verifies.
_VERIFIES = re.compile(r".*, \dD(?:, axisymmetric)?, (.+)")
#: A picture in cases/README.md, and the remarks below it, which may have more of its pictures.
_SHOWN = r"^!\[(.*?)\]\(pictures/{0}\.png\)\n((?:(?!#|\||!\[.*pictures/(?!{0}-)).*\n)*)"
_MARKED = re.compile(r"[`*]|\[([^\]]*)\]\([^)]*\)")


@dataclass(frozen=True)
class Facts:
    """A case of the folder cases/: its name, as ``pgimp init`` takes it, and its text."""

    name: str
    text: str
    page: str  # the text of cases/README.md

    @property
    def key(self) -> str:
        """The name of its picture, page and notebook."""
        return self.name.replace("/", "-")

    @property
    def path(self) -> str:
        return f"{self.name}.yaml"

    @cached_property
    def header(self) -> list[str]:
        """The lines of the comment at the head of the file."""
        head = re.match(r"(?:#.*\n)*", self.text)
        return [line[2:] for line in head[0].splitlines()] if head else []

    @property
    def title(self) -> str:
        return self.header[0].rstrip(".")

    @cached_property
    def parts(self) -> dict[str, str]:
        """Physics, Source, Exact, Expect, Size and Command, each in one line."""
        found: dict[str, list[str]] = {}
        lines: list[str] = []
        for line in self.header[1:]:
            if start := _PART.fullmatch(line):
                lines = found[start[1]] = [start[2]]
            else:
                lines.append(line.strip())
        return {name: " ".join(filter(None, part)) for name, part in found.items()}

    @property
    def command(self) -> str:
        return _OTHER_WAY.sub("", self.parts["Command"])

    @cached_property
    def contents(self) -> dict:
        return YAML(typ="safe").load(self.text)

    @property
    def dimensions(self) -> int:
        return self.contents["dimensions"]

    @property
    def verifies(self) -> str:
        """What is compared with what, as the row of the case says it."""
        row = next((row for name, row in _ROW.findall(self.page) if name == self.name), "")
        cells = [cell.strip() for cell in row.split("|")]
        found = _VERIFIES.fullmatch(cells[0])
        return _MARKED.sub(r"\1", found[1]) if found else ""

    @property
    def picture(self) -> Path:
        return CASES / "pictures" / f"{self.key}.png"

    @cached_property
    def _shown(self) -> re.Match | None:
        return re.search(_SHOWN.format(re.escape(self.key)), self.page, re.MULTILINE)

    @property
    def shows(self) -> str:
        """What is to be seen in the picture."""
        return self._shown[1] if self._shown else ""

    @property
    def remarks(self) -> str:
        """The text below the picture, in Markdown as seen from cases/."""
        return self._shown[2].strip() if self._shown else ""

    @property
    def modules(self) -> list[str]:
        """Python files beside the cases that have its materials."""
        return re.findall(r"--import cases/([\w-]+)\.py", self.text)


def cases(folder: Path = CASES) -> list[Facts]:
    """All cases of a folder and of those within; studies are none."""
    page = (folder / "README.md").read_text(encoding="utf-8")
    return [Facts(name, path.read_text(encoding="utf-8"), page) for name, path in _files(folder)]


def studies(folder: Path = CASES) -> list[Facts]:
    """All studies, with their first lines."""
    paths = sorted((folder / STUDIES).glob("*.yaml"))
    return [Facts(f"{STUDIES}/{path.stem}", path.read_text(encoding="utf-8"), "") for path in paths]


def _files(folder: Path) -> list[tuple[str, Path]]:
    found = {path.relative_to(folder).with_suffix(""): path for path in folder.rglob("*.yaml")}
    results = {name for name in found if any(part.endswith(".out") for part in name.parts)}
    wanted = sorted(name for name in found.keys() - results if name.parts[0] != STUDIES)
    return [(name.as_posix(), found[name]) for name in wanted]
