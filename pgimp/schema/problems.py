"""Problems of a case: path and text."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any, NamedTuple

from pydantic_core import InitErrorDetails, PydanticCustomError, ValidationError

MOST_PROBLEMS = 1000
"""At most this number of problems is listed for a part of a case."""

KIND, ABSENT = "problem", "absent"
"""Error types under which pydantic carries a `Problem`; absent: the last key is not there."""


class Problem(NamedTuple):
    """One problem of a case."""

    path: tuple[str | int, ...]
    """Keys and list indices from the checked value down to the culprit."""
    text: str
    """The error and its remedy: starts in lower case, ends without a full stop."""
    absent: bool = False
    """Whether the last key of `path` is what is missing."""


def problem(text: str, absent: bool = False) -> PydanticCustomError:
    """Return an error for a validator to raise, with `text` unchanged."""
    return PydanticCustomError(ABSENT if absent else KIND, "{text}", {"text": text})


def raise_problems(title: str, problems: Iterable[Problem], value: Any = None) -> Any:
    """Raise the `problems` with `value` at once; do nothing when there are none.

    Raises
    ------
    ValidationError
        Its paths start at `value`; pydantic puts the path of the calling validator before them.
    """
    details = [
        InitErrorDetails(type=problem(item.text, item.absent), loc=item.path, input=value)
        for item in islice(problems, MOST_PROBLEMS)
    ]
    if details:
        raise ValidationError.from_exception_data(title, details)
