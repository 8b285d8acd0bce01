"""Numbers so large or small that results exceed the range of float64."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pgimp.schema.dispatch import plain
from pgimp.schema.problems import Problem

#: In any units no physical value is near these, and a product of two fits a float64.
SMALLEST, LARGEST = 1e-150, 1e150
# Parts whose numbers are divisors, with few exceptions. Elsewhere, as in the tail of a pulse, the
# smallest count as zero.
_DIVISORS = ("materials", "time", "grid")
_NO_DIVISORS = ("origin", "poisson", "viscosity")


def check_numbers(parts: Mapping[str, object]) -> Iterator[Problem]:
    """Check the numbers of all parts of a case, given by their key."""
    for name, part in parts.items():
        yield from _check((name,), part, name in _DIVISORS)


def _check(path: tuple[str | int, ...], value: object, divides: bool) -> Iterator[Problem]:
    value = plain(value)
    if isinstance(value, Mapping | tuple | list):
        entries = value.items() if isinstance(value, Mapping) else enumerate(value)
        for key, entry in entries:
            yield from _check((*path, key), entry, divides and key not in _NO_DIVISORS)
    elif isinstance(value, int | float) and value != 0:
        if abs(value) > LARGEST:
            what, limit = "large", f"at most {LARGEST:g}"
        elif divides and abs(value) < SMALLEST:
            what, limit = "small", f"at least {SMALLEST:g}"
        else:
            return
        yield Problem(
            path, f"{value:g} is too {what} to compute with ({limit}); choose other units"
        )
