"""Values of options on the command line: lists, numbers, ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from pgimp.errors import UsageError

N = TypeVar("N")


def listed(text: str | None) -> list[str]:
    """Return the words of an option, with commas between them."""
    return [part.strip() for part in text.split(",") if part.strip()] if text else []


def numbers(text: str | None, option: str, kind: Callable[[str], N]) -> list[N]:
    """Return the numbers of an option, with commas between them; a UsageError if they are none."""
    if text is None:
        return []
    try:
        return [kind(part) for part in text.split(",")]
    except ValueError:
        what = "whole numbers" if kind is int else "numbers"
        raise UsageError(f"{option} {text}: {what}, with commas between them") from None


def limits(text: str | None, option: str) -> tuple[float, float] | None:
    """Return the two ends that an option names; a UsageError if they are none."""
    if text is None:
        return None
    found = numbers(text, option, float)
    if len(found) != 2 or not float("-inf") < found[0] < found[1] < float("inf"):
        raise UsageError(f"{option} {text}: two numbers, the lower one first, such as 0,5e4")
    return found[0], found[1]
