"""Values of particle fields, for the rows of a file that a rank writes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

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
    source : Source
        This rank's particles.
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
        source: Source,
        instead: Mapping[str, Array],
    ) -> None:
        self._types, self._fields, self._source, self._instead = types, kinds, source, instead
        self.error: str | None = None

    def collect(
        self, rows: Rows, group: list[Dataset], size: int | None = None
    ) -> Iterator[tuple[int, list[Array]]]:
        """Yield this rank's rows block by block: first row, and columns; collective."""
        moved = [one for one in group if one is not CONNECTIVITY]
        record = np.dtype([(one.name, one.dtype, one.tail) for one in moved])

        def fill(begin: int, end: int) -> Array:
            block = np.empty(end - begin, record)
            for name in record.names or ():
                block[name] = self._of(name, begin, end)
            return block

        for row, block in rows.collect(fill, record, size):
            numbers = np.arange(row, row + len(block), dtype=CONNECTIVITY.dtype)
            yield (
                row,
                [
                    numbers if one is CONNECTIVITY else np.ascontiguousarray(block[one.name])
                    for one in group
                ],
            )

    def _of(self, name: str, begin: int, end: int) -> Array:
        """Values of a field in a range of storage rows."""
        if name in self._instead:
            return self._instead[name][begin:end]
        source = self._source._replace(rows=self._source.rows[begin:end])
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
