"""Words that were renamed: keys and values of case and study files, columns of histories.

Old words are read for good, and mean what they meant. What pgimp writes and says has the new ones.
`KEYS`, `VALUES`, `OF_COLUMNS` and `COLUMNS` are all of them; the code knows the new ones alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

Path = tuple[str | int, ...]

#: Where a key stands, as keys joined by dots, with its old and its new name. `*` is any key or
#: index, a leading `**` any number of them. What a stage may change may have its old name there.
KEYS = (
    ("", "body_force", "body-force"),
    ("", "escape", "outflow"),
    ("method", "particles_per_cell", "particles-per-cell"),
    ("method", "relaxation", "pic-damping"),
    ("start", "settle", "equilibrate"),
    ("time.stages.*", "settle", "equilibrate"),
    ("time.stages.*", "strength", "strength-reduction"),
    ("bodies.*", "configuration", "formulation"),
    ("boundaries.*", "separating", "unilateral"),
    ("boundaries.*.absorbing", "held", "static-force"),
    ("contact.*.adhesion", "reach", "range"),
    ("exact.plane-wave", "swing", "polarization"),
    ("exact.plane-wave", "drift", "velocity"),
    ("exact.plane-wave", "waves", "wavenumber"),
    ("checkpoint.every", "wall", "wall-time"),
    ("**.heights", "part", "window"),
    ("bisect", "slide", "failure-displacement"),
)

#: Where a value stands, with its old and its new word; keys have their new names.
VALUES = (
    ("bodies.*.formulation", "initial", "total-lagrangian"),
    ("bodies.*.formulation", "current", "updated-lagrangian"),
    ("bodies.*.surface", "cut", "cut-particles"),
    ("bodies.*.surface", "whole", "whole-particles"),
    ("method.volumetric", "mean", "b-bar"),
    ("boundaries.*", "separating", "unilateral"),
    ("contact.*.law", "tied", "tie"),
)

#: Where names of columns stand.
OF_COLUMNS = ("accuracy.of", "error", "error.column", "columns.*", "columns.*.column")

#: Columns of the history: how an old name begins, and the new name.
COLUMNS = (
    (r"tool\.(.*)\.inside", r"rigid.\1.penetrating-particles"),
    (r"tool\.", "rigid."),
    (r"beyond\.", "overlap-mass."),
    (r"escaped\.", "outflow."),
    (r"volume\.(.*)\.carried", r"volume.\1.particles"),
)

#: New words by older ones, wherever they stand.
FORMER = {old.replace("_", "-"): new for _, old, new in (*KEYS, *VALUES)}

_STAGE = ("time", "stages", "*")


def new_key(where: Path, key: str | int) -> str | int:
    """Return the new name of a key in the mapping at a path; its own if it has not changed."""
    for pattern, old, new in KEYS:
        if key == old and _fits(pattern, where):
            return new
    return key


def new_value(where: Path, value: str) -> str:
    """Return the new word for the text at a path; itself if it has not changed."""
    for pattern, old, new in VALUES:
        if value == old and _fits(pattern, where):
            return new
    if any(_fits(pattern, where) for pattern in OF_COLUMNS):
        return new_column(value)
    return value


def new_path(keys: Iterable[str]) -> list[str]:
    """Return the keys of a path by their new names."""
    found: list[str] = []
    for key in keys:
        found.append(str(new_key((*found,), key)))
    return found


def new_column(name: str) -> str:
    """Return the new name of a column of the history, or of a pattern of names."""
    for old, new in COLUMNS:
        changed, count = re.subn(f"^{old}", new, name)
        if count:
            return changed
    return name


def _fits(pattern: str, path: Path) -> bool:
    """Whether a path is one of a pattern, in the case or in a stage of it."""
    keys = pattern.split(".") if pattern else []
    if keys[:1] == ["**"]:
        return _same(keys[1:], path[1 - len(keys) :])
    return _same(keys, path) or (_same(_STAGE, path[:3]) and _same(keys, path[3:]))


def _same(keys: Iterable[str], path: Path) -> bool:
    keys = [*keys]
    return len(keys) == len(path) and all(
        key in ("*", part) for key, part in zip(keys, path, strict=True)
    )
