"""Particle columns of a varying material: parameters of kernels, values of the case.

Varying parameters are found by comparing the parameters for different values of the case. With
another Young's modulus both of Lame's constants change, with another density only the density.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from pgimp.jit.own import Own
from pgimp.physics.materials.parameters.vary import Varying
from pgimp.physics.variation import Variation
from pgimp.physics.variation.find import Variations, value_at

V = TypeVar("V", bound=Varying)


def leaves(value: tuple[object, ...]) -> list[Any]:
    """Leaves of nested tuples, numbers and others, in order."""
    found: list[Any] = []
    for part in value:
        if isinstance(part, tuple):
            found += leaves(part)
        else:
            found.append(part)
    return found


def _rebuilt(value: Any, given: Iterator[Any]) -> Any:
    """Nested tuples with other leaves."""
    if not isinstance(value, tuple):
        return next(given)
    parts = [_rebuilt(part, given) for part in value]
    return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)


class Layout(NamedTuple):
    """Layout of the varying parameters in the columns of a material's particles."""

    base: NamedTuple  #: The material's parameters with typical values.
    #: Indices of the varying parameters, ascending: the first columns of a particle.
    varying: list[int]
    paths: list[tuple[str, ...]]  #: Varying keys of the case.
    indices: list[int]  #: Column of each key's value.
    width: int  #: Number of columns.

    @property
    def marked(self) -> NamedTuple:
        """The material's parameters with `Own` in place of varying ones."""
        found = leaves(self.base)
        for index, leaf in enumerate(self.varying):
            found[leaf] = Own(index)
        return _rebuilt(self.base, iter(found))

    def packer(self) -> Callable[[NamedTuple, Sequence[float]], list[float] | None]:
        """Return a function that computes the columns of a particle.

        It takes the particle's parameters and values of the case. It returns None if the
        parameters differ from `base` in any but varying ones.
        """
        kind, base, varying = type(self.base), leaves(self.base), self.varying
        fixed = [(i, leaf) for i, leaf in enumerate(base) if i not in varying]
        others = [j for j, index in enumerate(self.indices) if index >= len(varying)]

        def pack(parameters: NamedTuple, values: Sequence[float]) -> list[float] | None:
            if type(parameters) is not kind:
                return None
            found = leaves(parameters)
            for i, leaf in fixed:
                if not same(found[i], leaf):
                    return None
            return [found[i] for i in varying] + [values[j] for j in others]

        return pack

    def values(self, row: np.ndarray) -> list[float]:
        """Return the values of the case in a particle's columns."""
        return [float(row[index]) for index in self.indices]


def layout_of(entry: V, make: Callable[[V], NamedTuple]) -> Layout:
    """Find the numbers in the kernels' parameters that depend on varying keys.

    A number does if another value of any key changes it; `make` makes the parameters of an entry.
    """
    variations: Variations = entry.variations
    paths = list(variations)
    base, entry_with = make(entry), entry.maker()
    own = [value_at(entry, path) for path in paths]
    first = leaves(base)
    varying: set[int] = set()
    given = [{i for i, leaf in enumerate(first) if same(leaf, value)} for value in own]
    for number, path in enumerate(paths):
        for value in _probes(variations[path], own[number]):
            try:
                other = make(entry_with({path: value}))
            except (ValidationError, ValueError):
                continue
            if type(other) is not type(base):
                continue
            found = leaves(other)
            varying |= {i for i, leaf in enumerate(found) if not same(leaf, first[i])}
            for j in range(len(paths)):
                now = value if j == number else own[j]
                given[j] &= {i for i, leaf in enumerate(found) if same(leaf, now)}
    order, indices = sorted(varying), []
    width = len(order)
    for j in range(len(paths)):
        there = [order.index(i) for i in given[j] & varying]
        indices.append(there[0] if there else width)
        width += not there
    return Layout(base, order, paths, indices, width)


def same(a: ArrayLike, b: ArrayLike) -> bool:
    """Whether two leaves are equal."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return bool(np.array_equal(a, b))
    return bool(a == b)


def _probes(variation: Variation, typical: float) -> list[float]:
    """Values near and far from a typical one; if the possible values are known, from these."""
    known = sorted({value for _, value in variation.known()})
    found = known[:: max(1, len(known) // 20)] + known[-1:]
    return (
        found
        + [typical * factor for factor in (1.01, 0.99, 1.3, 0.7, 2.0, 0.5)]
        + [typical + step for step in (1e-3, -1e-3)]
    )
