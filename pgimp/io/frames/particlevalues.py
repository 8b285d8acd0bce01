"""Values of particle fields, for the rows of a file that a rank writes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from pgimp.physics.fields import Field, Source
from pgimp.storage.datasets import Dataset
from pgimp.storage.rows import Rows

Array = np.ndarray

CONNECTIVITY = Dataset(
    "connectivity", "<i8", (), {"meaning": "the row itself, for the cells of XDMF readers"}
)


class Values:
    """Values for the rows of a file.

    Parameters
    ----------
    types : dict of str to str
        Type of each field in the file.
    kinds : dict of str to Field
        Definition of each field.
    at : callable
        Takes rows of this rank's particles; returns the data for their fields.
    storage : (n,) int64
        Those rows, in storage order.
    instead : mapping of str to ndarray
        See `pgimp.io.frames.particlefile.ParticleFile.write`.

    Attributes
    ----------
    error : str or None
        Error in the values of this rank's particles.
    """

    def __init__(
        self,
        types: Mapping[str, str],
        kinds: Mapping[str, Field],
        at: Callable[[Array], Source],
        storage: Array,
        instead: Mapping[str, Array],
    ) -> None:
        self._types, self._fields, self._instead = types, kinds, instead
        self._at, self._storage = at, storage
        self.error: str | None = None

    def collect(
        self, rows: Rows, groups: list[list[Dataset]], size: int | None = None
    ) -> Iterator[tuple[int, list[Array]]]:
        """Yield this rank's rows block by block: first row, and columns; collective.

        Those of a group of datasets go in the same messages. A single rank has none.
        """
        sent = [[one for one in group if one is not CONNECTIVITY] for group in groups]
        if rows.comm.size == 1:
            sent = [[one] for group in sent for one in group]
        types = [np.dtype([(one.name, one.dtype, one.tail) for one in group]) for group in sent]

        def fill(begin: int, end: int) -> list[Array]:
            source, found = self._at(self._storage[begin:end]), []
            for record in types:
                block = np.empty(end - begin, record)
                for name in record.names or ():
                    block[name] = self._of(name, source, begin, end)
                found.append(block)
            return found

        for row, found in rows.collect(fill, types, size):
            count = len(found[0]) if found else 0
            columns = {name: block[name] for block in found for name in block.dtype.names or ()}
            columns[CONNECTIVITY.name] = np.arange(row, row + count, dtype=CONNECTIVITY.dtype)
            yield (
                row,
                [np.ascontiguousarray(columns[one.name]) for group in groups for one in group],
            )

    def _of(self, name: str, source: Source, begin: int, end: int) -> Array:
        """Values of a field in a range of storage rows."""
        if name in self._instead:
            return self._instead[name][begin:end]
        values = self._fields[name].values(source)
        try:
            with np.errstate(over="raise", under="ignore"):
                return np.asarray(values, self._types[name])
        except FloatingPointError:
            self.error = self.error or (
                f"the {name} of a particle is beyond the range of float32; go on with --resume "
                "--set output.precision=float64"
            )
            return np.zeros(values.shape, self._types[name])
