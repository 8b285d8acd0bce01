"""Reading a case file: YAML, overrides, validation, messages with file, line and key path."""

from __future__ import annotations

from typing import TypeVar

from pydantic import BaseModel, ValidationError

from pgimp.case.locations import remember
from pgimp.case.schema import Case
from pgimp.case.writer import dump_case
from pgimp.errors import CaseError
from pgimp.schema.document import Document, decode, few, parse, top_level
from pgimp.schema.messages import dotted, explain
from pgimp.schema.overrides import Overrides, apply
from pgimp.schema.paths import starting_from
from pgimp.schema.problems import Problem
from pgimp.schema.words.renew import renew

__all__ = ["decode", "dump_case", "read_case"]

M = TypeVar("M", bound=BaseModel)


def read_case(text: str | bytes, filename: str = "case", overrides: Overrides = ()) -> Case:
    """Return the case that a case file defines.

    Parameters
    ----------
    text : str or bytes
        Content of the file; bytes are UTF-8.
    filename : str
        Name for messages.
    overrides : sequence of str, or mapping
        ``key.path=value`` each, as for ``--set``, or values by their paths.

    Returns
    -------
    Case
        Typed, checked as far as is possible without making particles.

    Raises
    ------
    CaseError
        With every problem on a line of its own (the first `document.MOST_MESSAGES`): file, line,
        key path, problem, allowed values.
    """
    document = read_document(text, filename)
    apply(document, overrides)
    with starting_from(filename):
        case = validate(Case, document, filename)
    remember(case, document, filename)
    return case


def read_document(text: str | bytes, filename: str) -> Document:
    """Return the keys and values of a file, by their new names, with their lines.

    Raises
    ------
    CaseError
        With file, line and column of the invalid part.
    """
    if isinstance(text, bytes):
        text = decode(text, filename)
    document = parse(text, filename)
    top_level(document, filename)
    renew(document, filename)
    return document


def validate(model: type[M], document: Document, filename: str) -> M:
    """Return the typed content of a file.

    Raises
    ------
    CaseError
        See `read_case`.
    """
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        problems = explain(model, error, document.data)
        raise CaseError(_report(problems, document, filename)) from None


def _report(problems: list[Problem], document: Document, filename: str) -> str:
    """Return a line for every problem, in the order of the file, overrides last."""
    lines = []
    for item in problems:
        at = document.location(item.path)
        where = f"{filename}:{at}" if isinstance(at, int) else at or filename
        order = at if isinstance(at, int) else 0 if at is None else len(document.locations)
        key = dotted(document.as_written(item.path))
        lines.append((isinstance(at, str), order, f"{where}: {key}: {item.text}"))
    texts = [text for _, _, text in sorted(lines, key=lambda line: line[:2])]
    return few(list(dict.fromkeys(texts)), filename)
