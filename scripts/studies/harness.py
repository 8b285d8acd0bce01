"""What all studies share: jobs, figures that are kept, tables with machine and date, pages."""

import argparse
import csv
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from datetime import date
from hashlib import sha256
from importlib.metadata import version
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from pgimp.io.rundir.runinfo import cpu

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "cases"
PAGES = ROOT / "scripts" / "pages"
TABLES = PAGES / "tables"


def out(name: str) -> Path:
    """Folder of a study's results, made if need be."""
    folder = ROOT / f"{name}.out"
    folder.mkdir(exist_ok=True)
    return folder


def origin(*more: str) -> str:
    """Machine, versions and date; `more` versions besides."""
    words = [f"{name} {version(name)}" for name in ("pgimp", "numba", "numpy")]
    return f"{cpu()} ({os.cpu_count()} cores), {', '.join([*words, *more])}, {date.today()}"


def options_of(prog: str, given: list[str] | None = None, **known: Any) -> Any:
    """What the command line of scripts/PROG says, or some words.

    By name there are the settings of an option, or the help of one that is on or off; one with
    `nargs: "*"` is no option. What is to be `among` some names may be words, or between commas.
    """
    parser = argparse.ArgumentParser(prog=f"scripts/{prog}")
    among = {}
    for name, settings in known.items():
        on_off = {"action": "store_true", "help": settings}
        more = on_off if isinstance(settings, str) else {**settings}
        if names := more.pop("among", None):
            among[name] = names
            more = {"default": "", "help": ", ".join(names)} | more
        parser.add_argument(name if more.get("nargs") == "*" else f"--{name}", **more)
    options = parser.parse_args(given)
    for name, names in among.items():
        setattr(options, name, chosen(parser, getattr(options, name), names))
    return options


def chosen(
    parser: Any, names: str | Iterable[str], known: Iterable[str], what: str = ""
) -> tuple[str, ...]:
    """Names given in a list or between commas; one that is not known, of `what`, is an error."""
    given = names.split(",") if isinstance(names, str) else names
    found = tuple(filter(None, given))
    for name in found:
        if name not in known:
            parser.error(f"there is no {what}{name}; there are {', '.join(known)}")
    return found


def key(name: Any) -> str:
    """Key in a file of a figure's name, a text or a tuple."""
    return name if isinstance(name, str) else "/".join(map(str, name))


class Kept(dict[str, Any]):
    """Figures that are kept from run to run in a JSON file; a `new` one forgets what it has.

    If files of the study are given as `sources`, figures count only while these, pgimp's and the
    cases are what they were when the figures were measured.
    """

    def __init__(self, path: Path, new: bool = False, sources: Iterable[Path] = ()) -> None:
        super().__init__()
        self._path = path
        digest = _digest(sources) if sources else None
        if path.exists() and not new:
            found = json.loads(path.read_text(encoding="utf-8"))
            if found.get("digest") == digest:
                self.update(found)
        if digest:
            self["digest"] = digest

    def save(self) -> None:
        self._path.write_text(json.dumps(self, indent=1, default=float), encoding="utf-8")

    def add(self, name: Any, value: Any) -> None:
        """Keep a figure, or several in one."""
        self[key(name)] = value
        self.save()

    def of(self, name: Any, function: Any, *arguments: Any) -> Any:
        """A figure, measured if it is not there."""
        if key(name) not in self:
            self.add(name, function(*arguments))
        return self[key(name)]


def _digest(sources: Iterable[Path]) -> str:
    """Of some files, what studies share, pgimp's sources and the cases."""
    found = sha256()
    shared = Path(__file__).parent.glob("*.py")
    for path in sorted([*sources, *shared, *(ROOT / "pgimp").rglob("*.py"), *CASES.glob("*.yaml")]):
        found.update(path.read_bytes())
    return found.hexdigest()


def perform(jobs: Mapping[Any, tuple], processes: int) -> Iterable[tuple[Any, Any]]:
    """Names and results of jobs, (function, *arguments) each, as they end in some processes."""
    with ProcessPoolExecutor(min(processes, os.cpu_count() or 1), get_context("spawn")) as pool:
        waiting = {pool.submit(*job): name for name, job in jobs.items()}
        for future in as_completed(waiting):
            yield waiting[future], future.result()


class Table:
    """A table in Markdown, whose lines are shown as they are found."""

    def __init__(self, *titles: Any) -> None:
        self.lines = [_line(titles), "|---" * len(titles) + "|"]

    def add(self, *cells: Any) -> None:
        self.lines.append(_line(cells))
        print(self.lines[-1], flush=True)

    def keep(self, *cells: Any) -> None:
        """Add a line that is not new."""
        self.lines.append(_line(cells))

    def text(self, note: str = "") -> str:
        """All of it, and a note below."""
        return "\n".join([*self.lines, *(("", note) if note else ()), ""])


def _line(cells: Iterable[Any]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


def table(titles: Iterable[Any], rows: Iterable[Iterable[Any]], note: str = "") -> str:
    found = Table(*titles)
    found.lines += map(_line, rows)
    return found.text(note)


def standing(name: str, mark: str = "") -> dict[tuple[str, str], list[str]]:
    """Further cells of the table that there is, by the first cells of two lines.

    These are the line itself and the one that it is "the same" as, or itself again. A `mark` at the
    end of a first cell does not count.
    """
    found, head, path = {}, "", TABLES / f"{name}.md"
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        if line.startswith("| "):
            words, *cells = line[2:-2].split(" | ")
            words = words.removesuffix(mark)
            head = head if words.startswith("the same") else words
            found[head, words] = cells
    return found


def put(texts: Mapping[str, str], whole: Path | None = None, page: bool = True) -> None:
    """Write tables by name, the pages that show them, and all into one file.

    Each becomes scripts/pages/tables/NAME.md, unless `page` is false; `whole` has all of them.
    """
    if whole:
        whole.write_text("\n".join(texts.values()), encoding="utf-8")
    if page:
        for name, text in texts.items():
            (TABLES / f"{name}.md").write_text(text, encoding="utf-8")
        subprocess.run([sys.executable, PAGES], check=True)


def write_csv(records: list[dict[str, Any]], path: Path) -> None:
    """Write all records as they are."""
    keys = list(dict.fromkeys(name for record in records for name in record))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, keys)
        writer.writeheader()
        writer.writerows(records)
