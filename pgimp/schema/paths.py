"""Names of files in a case; relative names start from the folder of the case file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Annotated

from pydantic import AfterValidator, StringConstraints

from pgimp.schema.base import one_line

_FOLDER: ContextVar[str] = ContextVar("folder", default="")


@contextmanager
def starting_from(filename: str) -> Iterator[None]:
    """Resolve names of files from the folder of a file while its case is validated."""
    token = _FOLDER.set(os.path.dirname(os.path.abspath(filename)))
    try:
        yield
    finally:
        _FOLDER.reset(token)


def _absolute(name: str) -> str:
    """Make a name absolute, so that the case as written into the run directory finds the file."""
    return os.path.normpath(os.path.join(_FOLDER.get() or os.getcwd(), name))


FileName = Annotated[
    str,
    StringConstraints(strict=True, min_length=1, max_length=4000),
    AfterValidator(one_line),
    AfterValidator(_absolute),
]
"""Name of a file; absolute once it is validated."""
