"""Files of figures: their kinds, what may be replaced, and their content."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.errors import UsageError, explain
from pgimp.storage import atomic
from pgimp.storage.plain import open_plain
from pgimp.utilities.plot.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "pdf", "svg")
MOVIES = ("gif", "mp4")
_BEGINNINGS = {
    "gif": rb"GIF8",
    "mp4": rb"(?s).{4}ftyp",
    "png": rb"\x89PNG\r\n",
    "pdf": rb"%PDF-",
    "svg": rb"(<\?xml|<svg|\s)",
}


def output_path(name: str, formats: Sequence[str] = (*FORMATS, *MOVIES, "csv")) -> Path:
    """Return the output path, after checking for an existing file.

    Raises
    ------
    UsageError
        If it has another ending, cannot be there, or another kind of file is there.
    """
    path = Path(name)
    kind = path.suffix[1:].lower()
    if kind not in formats:
        endings = ", ".join(f".{one}" for one in formats)
        raise UsageError(f"{name}: the name must end in {endings}")
    if not path.parent.is_dir():
        raise UsageError(f"{name}: there is no folder {path.parent}")
    try:
        if path.is_dir():
            raise UsageError(f"{name} is a directory")
        if path.exists():
            with open_plain(path) as stream:
                beginning = stream.read(16)
            fits = (
                Table.is_one(beginning)
                if kind == "csv"
                else re.match(_BEGINNINGS[kind], beginning) is not None
            )
            if beginning and not fits:
                what = "table of pgimp plot" if kind == "csv" else f"{kind.upper()} file"
                raise UsageError(f"{name} exists and is no {what}; it is left as it is")
    except OSError as error:
        raise UsageError(f"cannot read {name}: {explain(error)}") from error
    return path


def rendered(figure: Figure, kind: str) -> bytes:
    """Return the file of a figure; the same figure gives the same bytes."""
    stream = io.BytesIO()
    dates = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
    # Titles of a first row of pictures may exceed the layout's estimate.
    room, about = 0.08, dates.get(kind)
    figure.savefig(stream, format=kind, metadata=about, bbox_inches="tight", pad_inches=room)
    return stream.getvalue()


def write(path: Path, content: str | bytes) -> None:
    """Write a file, completely or not at all.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    try:
        atomic.write(path, content)
    except OSError as error:
        raise UsageError(f"cannot write {path}: {explain(error)}") from error
