"""Locations of the parts of a case in its file, for errors found after it was read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from pgimp.errors import CaseError
from pgimp.schema.document import Document
from pgimp.schema.messages import dotted
from pgimp.schema.words.renamed import new_value

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: A line of a message that begins with a key.
_KEY = re.compile(r"([a-z][a-z-]*(?:\.[A-Za-z0-9_-]+)*): ")


def remember(case: Case, document: Document, filename: str) -> None:
    """Store with a case the file and the lines of its parts."""
    # The first stage has its keys at the same paths as the case.
    for each in (case, case.stages[0]):
        each.__dict__["written"] = (filename, replace(document, data=None))


def old_words(case: Case) -> str:
    """Return the older words in a case's file, each with the new one; empty without any."""
    document = case.__dict__["written"][1] if "written" in case.__dict__ else Document(None)
    pairs = {old: path[-1] for path, old in document.old_keys.items()}
    pairs |= {old: new_value(path, old) for path, old in document.old_values.items()}
    return ", ".join(f"{old} (now {new})" for old, new in pairs.items())


@contextmanager
def located(case: Case) -> Iterator[None]:
    """Prefix the lines of a `CaseError` raised within by file and line of their keys.

    A case without a file has only the keys.
    """
    try:
        yield
    except CaseError as error:
        if type(error) is not CaseError or "written" not in case.__dict__:
            raise
        filename, document = case.__dict__["written"]
        lines = [_with_location(line, filename, document) for line in str(error).split("\n")]
        raise CaseError("\n".join(lines)) from None


def _with_location(line: str, filename: str, document: Document) -> str:
    match = _KEY.match(line)
    if match is None:
        return line
    path = tuple(int(part) if part.isdecimal() else part for part in match[1].split("."))
    location = document.location(path)
    if location is None:
        return line
    line = dotted(document.as_written(path)) + line[match.end(1) :]
    return f"{filename}:{location}: {line}" if isinstance(location, int) else f"{location}: {line}"
