"""A file of particles, for frames and failed runs: complete or absent."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pgimp.io.frames.mesh import Column, Mesh
from pgimp.io.frames.particlevalues import CONNECTIVITY, Values
from pgimp.io.frames.writers import begin_frame
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.physics.fields import Source
from pgimp.scene.bodies.saved_state import saved_attributes
from pgimp.storage import chunks
from pgimp.storage.atomic import temporary
from pgimp.storage.chunks import Chunks, chunk_rows
from pgimp.storage.datasets import Dataset, Layout, lay_out
from pgimp.storage.framefile import FrameFile
from pgimp.storage.rows import Rows
from pgimp.storage.unfinished import Unfinished, explained_errors, removed_on_error

Array = np.ndarray
At = Callable[[Array], Source]

FORMAT_VERSION = 1
# Placeholders of time and step in the common header of all frames, with characters that no case's
# text has.
_TIME, _STEP = b"\x01time\x02\x03\x04", b"\x01step\x02\x03\x04"
# Fields go together if a rank has at most this number of bytes of them in total.
_TOGETHER = 4 << 20


class ParticleFile:
    """Writes files of particles, a row each in ascending id, with fields and attributes.

    Parameters
    ----------
    case : Case
        Gives title and units.
    fields : list of str
        Fields in the files.
    precision : str
        Type of real numbers: float64 or float32.
    compressed : bool
        Whether the datasets are compressed.

    Attributes
    ----------
    types : dict of str to str
        Type of each field in the files.
    kinds : dict of str to Field
        Definition of each field.
    """

    def __init__(
        self,
        case: Any,
        scene: Any,
        fields: list[str],
        precision: str = "float64",
        compressed: bool = False,
    ) -> None:
        self.fields, self.kinds = fields, {name: scene.fields[name] for name in fields}
        self.types = {
            name: np.dtype(precision).newbyteorder("<").str if dtype == "<f8" else dtype
            for name, dtype in ((name, scene.fields[name].dtype) for name in fields)
        }
        self._layout, self._count = Layout({}, {}, 0), -1
        self._scene = scene
        self._compressed = compressed
        names = {"body": list(scene.body_names), "material": list(scene.materials.names)}
        self._datasets = [CONNECTIVITY] + [
            Dataset(
                name,
                self.types[name],
                (field.columns,) if field.columns else (),
                {"meaning": field.meaning}
                | ({"components": field.components.split()} if field.components else {})
                | ({"names": names[name]} if name in names else {}),
            )
            for name, field in ((name, scene.fields[name]) for name in fields)
        ]
        self._attributes = {
            "format": FORMAT_VERSION,
            "title": str(case.title or ""),
            "units": str(case.units or ""),
            "materials": names["material"],
        } | saved_attributes(scene)

    def mesh(self, path: Path, state: tuple[float, int], count: int) -> Mesh:
        """Return the content of a file with `count` particles, at a time and step."""
        fields = {
            name: Column(self.kinds[name].columns, dtype, self.kinds[name].kind)
            for name, dtype in self.types.items()
        }
        return Mesh(path, *state, count, count, 1, fields)

    def rows(
        self, comm: Communicator, ids: Array, storage: Array, count: int, complete: bool
    ) -> Rows:
        """Rows of such a file; collective. See `Rows`."""
        unit = chunks.ROWS if self._compressed else 1
        return Rows(comm, ids, storage, count, complete, unit, self._scene.stateless)

    def write(
        self,
        path: Path,
        at: At,
        rows: Rows,
        state: tuple[float, int],
        what: str,
        instead: Mapping[str, Array] = MappingProxyType({}),
    ) -> Unfinished:
        """Write a file under a temporary name; collective.

        Parameters
        ----------
        path : Path
            The file; renamed to this at the end, when it is completely on the disk.
        at : callable
            Takes rows of this rank's particles; returns the data for their fields.
        rows : Rows
            Rows of the particles to write, with the writing ranks.
        state : (float, int)
            Simulated time and step, for the attributes.
        what : str
            The action, for messages.
        instead : mapping of str to ndarray
            Values of this rank's rows, in storage order, for fields with values other than the
            particles' own.

        Returns
        -------
        Unfinished
            The file; the particles are no longer needed.

        Raises
        ------
        RunError
            On every rank, if the disk is full, or the file cannot be created; it then does not
            exist. Other errors are raised at the end.
        """
        comm, part = rows.comm, temporary(path)
        attributes = {"time": state[0], "step": np.int64(state[1])} | self._attributes
        with removed_on_error(part, comm):
            # HDF5 cannot chunk an empty dataset.
            way = self._in_chunks if self._compressed and rows.count else self._in_place
            values = Values(self.types, self.kinds, at, rows.storage, instead)
            file = way(part, rows, attributes, values, what)
            file.error = file.error or values.error
            return Unfinished(part, path, file, comm, what)

    def _in_place(
        self, part: Path, rows: Rows, attributes: dict[str, object], values: Values, what: str
    ) -> FrameFile:
        """Write each row at its offset, in contiguous datasets."""
        says: dict[int, bytes] = {}

        def begin() -> dict[str, int]:
            if self._count != rows.count:
                stands_for = {"time": np.frombuffer(_TIME, "<f8")[0]}
                stands_for |= {"step": np.frombuffer(_STEP, "<i8")[0]}
                header = attributes | stands_for
                self._layout = lay_out(self._datasets, rows.count, header, more=begin_frame)
                self._count = rows.count
            time, step = np.array(attributes["time"], "<f8"), np.array(attributes["step"], "<i8")
            for place, data in self._layout.parts.items():
                says[place] = data.replace(_TIME, time.tobytes()).replace(_STEP, step.tobytes())
            with explained_errors(what):
                self._layout.create(part)
            return self._layout.offsets

        offsets = on_root(rows.comm, begin)
        file = FrameFile(part, rows.comm)
        for where, data in says.items():
            file.write(where, data)
        groups = list(self._groups(rows))
        for some in [groups] if rows.short else [[group] for group in groups]:
            for row, columns in values.collect(rows, some):
                for dataset, column in zip(chain(*some), columns, strict=True):
                    file.write(offsets[dataset.name] + row * dataset.row_bytes, column)
        return file

    def _in_chunks(
        self, part: Path, rows: Rows, attributes: dict[str, object], values: Values, what: str
    ) -> FrameFile:
        """Compress each chunk of rows, and write it at the offset that rank 0 assigns."""
        made: list[Chunks] = []
        says: dict[int, bytes] = {}
        length = chunk_rows(rows.count)

        def begin() -> None:
            with explained_errors(what):
                made.append(Chunks(part, self._datasets, rows.count, attributes))

        def place(group: list[Dataset], sizes: list[list[Array]]) -> list[Array]:
            with explained_errors(what):
                return [
                    made[0].place(dataset.name, np.concatenate(of_all))
                    for dataset, of_all in zip(group, zip(*sizes, strict=True), strict=True)
                ]

        def finish() -> None:
            with explained_errors(what):
                says.update(made[0].finish(begin_frame))

        on_root(rows.comm, begin)
        file = FrameFile(part, rows.comm)
        try:
            for group in self._groups(rows):
                packed: list[list[bytes]] = [[] for _ in group]
                for _, columns in values.collect(rows, [group], length):
                    for column, own in zip(columns, packed, strict=True):
                        own.append(chunks.compress(column, length))
                sizes = [np.array([len(data) for data in own], np.int64) for own in packed]
                places = on_root(rows.comm, partial(place, group, rows.comm.gather(sizes)))
                first = rows.first // length
                for own, where in zip(packed, places, strict=True):
                    for data, at in zip(own, where[first : first + len(own)], strict=True):
                        file.write(int(at), data)
            on_root(rows.comm, finish)
            for begins, text in says.items():
                file.write(begins, text)
        except BaseException:
            file.abandon()
            raise
        finally:
            for one in made:
                one.close()
        return file

    def _groups(self, rows: Rows) -> Iterator[list[Dataset]]:
        """Yield datasets whose values are moved together; the same on every rank."""
        group, size = [CONNECTIVITY], 0  # available on every rank
        each = -(-rows.count // rows.comm.size)
        for dataset in self._datasets[1:]:
            more = each * dataset.row_bytes
            if size and size + more > _TOGETHER:
                yield group
                group, size = [], 0
            group.append(dataset)
            size += more
        yield group
