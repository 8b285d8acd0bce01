"""Files of the probes in a run directory."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from pgimp.errors import CaseError
from pgimp.storage.plain import read_plain

PROBES = "probes"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,99}")


def probe_file(directory: Path, name: str) -> Path:
    """Return the file of a probe."""
    return directory / PROBES / f"{name}.csv"


def probe_files(directory: Path) -> Iterator[Path]:
    """Yield the files of the probes in the case of a run directory, existing or not.

    The folder may have other files, which do not belong to the run.
    """
    for name in _of_case(directory):
        yield probe_file(directory, name)


def probes_ever(directory: Path, run: dict[str, Any] | None) -> set[str]:
    """Return the names of all probes that a run had, also those that its case no longer has.

    Parameters
    ----------
    run : dict or None
        Content of run.json; each of its starts lists the probes so far.
    """
    starts = run["starts"] if run else []
    known = [start[PROBES] for start in starts if isinstance(start.get(PROBES), list)]
    return {*_of_case(directory), *(name for names in known for name in _names(names))}


def _of_case(directory: Path) -> Iterable[str]:
    from pgimp.schema.document import LARGEST_FILE

    with suppress(OSError):
        return _of_text(read_plain(directory / "case.yaml", LARGEST_FILE))
    return ()


@lru_cache(maxsize=1)  # a start calls it several times for the same text
def _of_text(text: bytes) -> tuple[str, ...]:
    from pgimp.schema.document import parse

    data = None
    with suppress(UnicodeDecodeError, CaseError):
        data = parse(text.decode(), "case.yaml").data
    probes = data.get(PROBES) if isinstance(data, dict) else None
    return tuple(_names(probes if isinstance(probes, dict) else ()))


def _names(found: Iterable[object]) -> Iterator[str]:
    """Yield valid names of probes: only these become names of files to delete."""
    yield from (str(name) for name in found if _NAME.fullmatch(str(name)))
