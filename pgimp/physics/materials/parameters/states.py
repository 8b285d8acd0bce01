"""State variables of a scene's materials: offsets in a particle's row, and initial values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.physics.fields import TENSOR, Field, Source
from pgimp.physics.materials.base import State, state_width, states_of


class Kept(NamedTuple):
    """A state variable in a scene."""

    state: State  #: Declaration in the materials.
    #: (materials,) int64: Offset in a particle's row, by material; -1 for materials without it.
    first: np.ndarray


def initial_row(parameters: NamedTuple, dimensions: int, width: int) -> np.ndarray:
    """Initial state of a material's particle, padded with zeros to `width`."""
    row, first = np.zeros(width), 0
    for state in states_of(type(parameters)):
        last = first + state.width(dimensions)
        start = state.initial
        row[first:last] = getattr(parameters, start) if isinstance(start, str) else start
        first = last
    return row


class States:
    """State variables of the materials in use.

    Each material's state variables begin at offset 0 of a particle's row.

    Parameters
    ----------
    names : sequence of str
        Names of the materials, for messages.
    materials : sequence of NamedTuple
        Parameters of the materials.
    dimensions : int
        1, 2 or 3.

    Attributes
    ----------
    width : int
        Numbers in a particle's row.
    initial : (materials, width) float64
        Initial states.
    kept : dict of str to Kept
        State variables by name.
    fields : dict of str to Field
        Fields of them for frames and probes: nan in particles of materials without them.

    Raises
    ------
    UsageError
        If two materials declare one name differently.
    """

    def __init__(
        self, names: Sequence[str], materials: Sequence[NamedTuple], dimensions: int
    ) -> None:
        self.width = max(state_width(type(each), dimensions) for each in materials)
        self.initial = np.zeros((len(materials), self.width))
        self.kept: dict[str, Kept] = {}
        for i, each in enumerate(materials):
            self.initial[i] = initial_row(each, dimensions, self.width)
            first = 0
            for state in states_of(type(each)):
                nowhere = np.full(len(materials), -1)
                known = self.kept.setdefault(state.name, Kept(state, nowhere))
                if (state.unit, state.tensor) != (known.state.unit, known.state.tensor):
                    other = names[int(np.argmax(known.first >= 0))]
                    raise UsageError(
                        f"materials.{names[i]}: its state '{state.name}' is not of the same kind "
                        f"or unit as that of materials.{other}; give one of them another name"
                    )
                known.first[i] = first
                first += state.width(dimensions)
        self.fields = {name: _field(kept) for name, kept in self.kept.items()}

    def first(self, name: str, material: int) -> int:
        """Offset of a state in the row of a material's particles; -1 if the material has none."""
        return int(self.kept[name].first[material]) if name in self.kept else -1


def _field(kept: Kept) -> Field:
    """Field of a state variable in frames."""
    state, first = kept

    def values(source: Source) -> np.ndarray:
        table = source.take("state")
        begin = first[np.asarray(source.body_material)[source.take("body")]]
        has = begin >= 0
        if not state.tensor:
            found = np.full(len(table), np.nan)
            found[has] = table[has, begin[has]]
            return found
        width = state.width(source.dimension)
        found = np.zeros((len(table), 6))
        found[~has] = np.nan
        for i in range(width):
            found[has, i] = table[has, begin[has] + i]
        return found

    meaning = f"{state.meaning} [{state.unit}]"
    return Field(values, meaning, *((TENSOR, "Matrix") if state.tensor else ()))
