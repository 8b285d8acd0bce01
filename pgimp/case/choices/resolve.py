"""A case whose method has what it leaves out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, ValidationError

from pgimp.case.checks.parts import check
from pgimp.case.choices.choose import Data, Open, candidates, filled, plain
from pgimp.schema.messages import dotted, explain
from pgimp.schema.problems import Problem

#: Stands for `pgimp.case.schema.Case`, whose module imports this one.
Case = Any

#: Most characters of a problem that lines quote.
_LONGEST = 110


def resolve(
    data: Data, open_keys: Open, typed: Callable[[Data], Case], sound: Callable[[Data], Case]
) -> Case:
    """Return the typed case with the best choices that are allowed in it.

    They are at its attribute ``chosen``, by their paths. A case with other errors has them as with
    plain values.

    Parameters
    ----------
    data : dict
        The case as plain data.
    open_keys : Open
        What it leaves out.
    typed, sound : callable
        Give the typed case of such data, and the one that is checked, too.

    Raises
    ------
    ValidationError
        If it is wrong, whatever is chosen.
    """
    first = plain(data, open_keys)
    try:
        looked_at = typed(first)
    except ValidationError:
        return sound(first)
    parts = {name: getattr(looked_at, name) for name in type(looked_at).model_fields}
    if not all(map(_may_be_cured, check(parts))):
        return sound(first)
    refused = ""
    for choices in candidates(looked_at, open_keys):
        tried = filled(data, {path: one.value for path, one in choices.items()})
        try:
            case = sound(tried)
        except ValidationError as error:
            refused = refused or _first(type(looked_at), error, tried)
            continue
        choices = {p: one.because(refused) for p, one in choices.items()}
        for each in (case, *case.stages):
            each.__dict__ |= {"chosen": choices, "left_out": open_keys}
        return case
    return sound(first)


def _may_be_cured(problem: Problem) -> bool:
    """Whether a problem depends on the method, or on what goes with it alone."""
    path = problem.path
    return path[:1] in (("method",), ("contact",), ("output",), ("probes",)) or (
        path[:1] == ("bodies",) and path[2:3] in (("formulation",), ("mass",), ("surface",))
    )


def _first(kind: type[BaseModel], error: ValidationError, data: Data) -> str:
    """The first problem of a case, with its key, in short."""
    found = explain(kind, error, data)[0]
    text = f"{dotted(found.path)}: {found.text}"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST].rpartition(' ')[0]} .."
