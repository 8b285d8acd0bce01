"""Quantities of a frame to draw: a field, a component, a magnitude."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.io.results.reader import Frame
from pgimp.physics import fields
from pgimp.schema.messages import shorten, unknown
from pgimp.utilities.plot.units import kind_of_field

Array = np.ndarray


def _component(function: Callable[[Array], Array], k: int) -> Callable[[Array], Array]:
    """Return a function of stresses for a component of what another one returns."""

    def values(sigma: Array) -> Array:
        found = function(sigma)
        return found[:, k] if found.ndim == 2 else found

    return values


_FROM_STRESS: dict[str, Callable[[Array], Array]] = {
    f"{name}.{part}" if part else name: _component(function, k)
    for name, function in fields.FROM_STRESS.items()
    for k, part in enumerate(fields.FIELDS[name].components.split() or [""])
}
_FIRST_CHOICE = ("von-mises", "stress", "velocity", "displacement", "volume")
_VECTOR = ["x", "y", "z"]
_NAMES = {"von-mises": "von Mises stress", "deformation": "F"}


class Quantity(NamedTuple):
    """A number for each particle of a frame."""

    text: str  #: Name on the command line: ``von-mises``, ``stress.xx``, ``velocity``.
    field: str  #: The underlying field.
    column: int | None  #: The component; None for a scalar, or for a vector's magnitude.

    @property
    def label(self) -> str:
        """Label on an axis, without its unit."""
        name, _, component = self.text.partition(".")
        return f"{_NAMES.get(name, name.replace('-', ' '))} {component}".rstrip()

    @property
    def kind(self) -> str:
        """Kind of quantity, which has a unit."""
        return kind_of_field(self.text.partition(".")[0])

    def rows(self, frame: Frame, first: int, last: int) -> Array:
        """Return the values of a range of particles, ndarray of float64, shape (last - first,).

        Raises
        ------
        RunError
            If the frame cannot be read.
        """
        values = frame.rows(self.field, first, last)
        if self.text in _FROM_STRESS and self.field == "stress":
            return _FROM_STRESS[self.text](values.astype(np.float64))
        if self.column is not None:
            values = values[:, self.column]
        elif values.ndim == 2:
            values = np.linalg.norm(values.astype(np.float64), axis=1)
        return values.astype(np.float64)


def quantity(text: str | None, frame: Frame, dimension: int) -> Quantity:
    """Find a frame's quantity by its name.

    Parameters
    ----------
    text : str or None
        ``FIELD`` or ``FIELD.COMPONENT``; None takes the first available of von Mises stress,
        stress, velocity, displacement and volume.
    dimension : int
        Dimensions of the case.

    Returns
    -------
    Quantity
        The quantity.

    Raises
    ------
    UsageError
        If the frame does not have it, or if it is not one number for each particle.
    """
    if text is None:
        there = [name for name in _FIRST_CHOICE if name in frame or _derived(name, frame)]
        text = there[0] if dimension > 1 or "stress" not in frame else "stress"
        text += ".xx" if text == "stress" else ""
    name, _, component = text.partition(".")
    if name not in frame:
        if _derived(text, frame):
            return Quantity(text, "stress", None)
        if name in fields.OPTIONAL:
            raise UsageError(
                f"the frames of {frame.path.parent.parent} have no {name}: name it in the case's "
                f"output.fields and run again; they have {', '.join(_names(frame))}"
            )
        raise UsageError(f"{unknown('field', text, _names(frame), 'there are')}")
    components = _components(name, frame)
    if not component and components in ([], _VECTOR):
        return Quantity(text, name, None)
    if component in components:
        return Quantity(text, name, components.index(component))
    if not components:
        raise UsageError(f"{name} has no components: write {name} instead of {shorten(text)}")
    if not component and text == name and "." not in text:
        hint = ", or von-mises, or pressure" if name == "stress" else ""
        raise UsageError(
            f"{name} has {len(components)} components; draw one of "
            f"{', '.join(f'{name}.{one}' for one in components)}{hint}"
        )
    raise UsageError(
        f"{name} has no component '{shorten(component)}'; it has {', '.join(components)}"
    )


def _derived(name: str, frame: Frame) -> bool:
    return name in _FROM_STRESS and "stress" in frame


def _components(name: str, frame: Frame) -> list[str]:
    """Return the names of a field's components; none for a scalar."""
    values = frame.rows(name, 0, 0)
    return fields.components_of(name, values.shape[1]) if values.ndim == 2 else []


def _names(frame: Frame) -> list[str]:
    """Return all quantities of a frame."""
    names = [name for name in ("von-mises", "pressure") if name not in frame]
    names = names if "stress" in frame else []
    for name in frame.fields:
        components = _components(name, frame)
        names += [name] if components in ([], _VECTOR) else []
        names += [f"{name}.{one}" for one in components]
    return names
