"""A file of particles, as frames are and what is kept of a failed run: whole or not there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pgimp.case import fields as case_fields
from pgimp.errors import RunError
from pgimp.output.collective import agree, explain, on_root
from pgimp.output.datasets import Dataset, create
from pgimp.output.fields import EVERY, Source
from pgimp.output.files import publish, temporary
from pgimp.output.framefile import FrameFile
from pgimp.output.rows import Rows

Array = np.ndarray

FORMAT_VERSION = 1
MEANING = case_fields.ALWAYS | case_fields.FIELDS | case_fields.FAILURE
CONNECTIVITY = Dataset(
    "connectivity", "<i8", (), {"meaning": "the row itself, for the cells of XDMF readers"}
)


class ParticleFile:
    """Writes files of particles, a row each in ascending id, with fields and attributes.

    Parameters
    ----------
    case : Case
        Gives title and units.
    scene : Scene
        What is simulated.
    fields : list of str
        Which fields the files have.
    """

    def __init__(self, case: Any, scene: Any, fields: list[str]) -> None:
        self.fields = fields
        self._scene = scene
        names = {"body": list(scene.body_names), "material": list(scene.material_names)}
        self._datasets = [CONNECTIVITY] + [
            Dataset(
                name,
                field.dtype,
                (field.columns,) if field.columns else (),
                {"meaning": MEANING[name].meaning}
                | ({"components": field.components.split()} if field.components else {})
                | ({"names": names[name]} if name in names else {}),
            )
            for name, field in ((name, EVERY[name]) for name in fields)
        ]
        self._attributes = {
            "format": FORMAT_VERSION,
            "title": str(case.title or ""),
            "units": str(case.units or ""),
            "dimensions": scene.dimension,
            "bodies": names["body"],
            "materials": names["material"],
        }

    def write(
        self,
        path: Path,
        particles: Any,
        rows: Rows,
        state: tuple[float, int],
        what: str,
        done: Callable[[], None],
        instead: Mapping[str, Array] = MappingProxyType({}),
    ) -> None:
        """Write a file; collective.

        Parameters
        ----------
        path : Path
            The file; it gets its name when all of it is on the disk.
        particles : Particles
            This rank's.
        rows : Rows
            Which of them are written, and by whom.
        state : (float, int)
            Simulated time and step, for the attributes.
        what : str
            What is being done, for messages.
        done : callable
            What rank 0 does once the file is there.
        instead : mapping of str to ndarray
            Values of this rank's rows, in the order of their storage, for fields that do not have
            those of the particles.

        Raises
        ------
        RunError
            On every rank, if the file could not be written whole; it is then not there.
        """
        comm, part = rows.comm, temporary(path)
        attributes = {"time": state[0], "step": np.int64(state[1])} | self._attributes

        def begin() -> dict[str, int]:
            try:
                return create(part, self._datasets, rows.count, attributes)
            except OSError as error:
                raise RunError(f"cannot {what}: {explain(error)}") from error

        def end() -> None:
            try:
                publish(part, path)
                done()
            except OSError as error:
                raise RunError(f"cannot {what}: {explain(error)}") from error

        try:
            offsets = on_root(comm, begin)
            self._fill(part, particles, rows, offsets, what, instead)
            on_root(comm, end)
        except BaseException:
            if comm.rank == 0:
                with suppress(OSError):
                    part.unlink(missing_ok=True)
            raise

    def _fill(
        self,
        part: Path,
        particles: Any,
        rows: Rows,
        offsets: dict[str, int],
        what: str,
        instead: Mapping[str, Array],
    ) -> None:
        scene, comm = self._scene, rows.comm
        source = Source(particles, rows.storage, scene.dimension, tuple(scene.body_material))
        file = FrameFile(part, rows, offsets)
        agree(comm, what, file.error)
        file.write(CONNECTIVITY.name, np.arange(rows.first, rows.last, dtype=CONNECTIVITY.dtype))
        for name in self.fields:
            field = EVERY[name]
            values = instead[name] if name in instead else field.values(source)
            file.write(name, rows.collect(np.asarray(values, dtype=field.dtype)))
        file.close()
        agree(comm, what, file.error)
        agree(comm, what, file.check())
