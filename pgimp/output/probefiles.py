"""Where the files of the probes are, and which there are in a run directory."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from pgimp.errors import CaseError

PROBES = "probes"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,99}")


def probe_file(directory: Path, name: str) -> Path:
    """Return the file of a probe."""
    return directory / PROBES / f"{name}.csv"


def probe_files(directory: Path) -> Iterator[Path]:
    """Yield the files of the probes that the case of a run directory names, there or not.

    The folder may hold others, which are not the run's.
    """
    from pgimp.case.document import parse

    data = None
    with suppress(OSError, UnicodeDecodeError, CaseError):
        data = parse((directory / "case.yaml").read_text(encoding="utf-8"), "case.yaml").data
    probes = data.get(PROBES) if isinstance(data, dict) else None
    for name in probes if isinstance(probes, dict) else ():
        if _NAME.fullmatch(str(name)):
            yield probe_file(directory, str(name))
