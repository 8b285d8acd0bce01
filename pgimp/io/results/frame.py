"""One frame of a run, read from its file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.errors import PgimpError, RunError, explain
from pgimp.io.results.tables import absent, data_frame
from pgimp.io.rundir.ownfiles import FRAME
from pgimp.storage.hdf5 import load_h5py, open_file
from pgimp.storage.plain import require_plain
from pgimp.terminal import escape

if TYPE_CHECKING:
    import pandas

Array = np.ndarray

#: The cells of XDMF, and the group of VTK: no fields.
FOR_READERS = ("connectivity", "VTKHDF")

#: Attribute of a frame's file with the names of its fields of cells.
OF_CELLS = "cell-fields"


def cell_fields(attributes: Any) -> list[str]:
    """Names of the fields of cells, by the attributes of a frame's file."""
    return [str(name) for name in attributes[OF_CELLS]] if OF_CELLS in attributes else []


class Frame:
    """The particles at one time; ``frame["stress"]`` reads a field.

    Parameters
    ----------
    path : Path
        The frame's file.

    Attributes
    ----------
    number : int
        Number of the frame in the run, from 0.
    time : float
        Simulated time.
    step : int
        Step after which it was written.
    fields : list of str
        Fields of the frame, in the order of the file format.
    types : dict of str to str
        Types of the fields; types of real numbers depend on the case's ``output.precision``.
    bodies, materials : list of str
        Names, by the index in the fields ``body`` and ``material``.

    Raises
    ------
    RunError
        If the file cannot be read; later on, when a field cannot.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        match = FRAME.fullmatch(path.name)
        self.number = int(match[1]) if match else 0
        with Reading(path) as file:
            self.time = float(file.attrs["time"])
            self.step = int(file.attrs["step"])
            self.bodies = [str(name) for name in file.attrs["bodies"]]
            self.materials = [str(name) for name in file.attrs["materials"]]
            self.fields = [name for name in file.names if name not in FOR_READERS]
            self.types = {name: file[name].dtype.newbyteorder("<").str for name in self.fields}
            self._count = len(file["id"])

    def __len__(self) -> int:
        """Return the number of particles."""
        return self._count

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the fields."""
        return iter(self.fields)

    def keys(self) -> list[str]:
        """Return the names of the fields; ``dict(frame)`` reads them all."""
        return list(self.fields)

    def __repr__(self) -> str:
        """Return its number and its fields."""
        fields = ", ".join(self.fields)
        said = f"<Frame {self.number}: t = {self.time:.6g}, {self._count} particles; {fields}>"
        return escape(said)

    def __contains__(self, name: object) -> bool:
        """Return whether the frame has a field."""
        return name in self.fields

    def __getitem__(self, name: str) -> Array:
        """Read a field of all particles, in ascending id.

        Parameters
        ----------
        name : str
            One of `fields`.

        Returns
        -------
        ndarray, shape (N,) or (N, k)
            The values.

        Raises
        ------
        KeyError
            If the frame does not have the field.
        """
        return self.rows(name, 0, self._count)

    def rows(self, name: str, first: int, last: int) -> Array:
        """Read a range of rows of a field.

        Parameters
        ----------
        name : str
            One of `fields`.
        first, last : int
            First row, and end (exclusive).

        Returns
        -------
        ndarray, shape (last - first,) or (last - first, k)
            The values.

        Raises
        ------
        KeyError
            If the frame does not have the field.
        """
        if name not in self.fields:
            raise KeyError(absent(f"field {name!r} in {self.path.name}", str(name), self.fields))
        with Reading(self.path) as file:
            return file[name][first:last]

    def to_pandas(self, *names: str) -> pandas.DataFrame:
        """Read fields into a pandas.DataFrame with a row for each particle.

        Parameters
        ----------
        *names : str
            The fields; by default all.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``id``; components of vectors and tensors are separate columns, such as
            ``position-x`` and ``stress-xy``.

        Raises
        ------
        KeyError
            If the frame does not have a field.
        UsageError
            If pandas is not installed.
        """
        chosen = [name for name in names or self.fields if name != "id"]
        return data_frame({"id": self["id"]} | {name: self[name] for name in chosen}, index="id")


# Errors of h5py for a file of other content, and errors from odd types and shapes.
_DAMAGES = (OSError, KeyError, TypeError, ValueError, AttributeError, RuntimeError)


class Reading:
    """A file open for reading; its errors are RunErrors with its name."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __enter__(self) -> Content:
        """Open the file."""
        try:
            require_plain(self.path)
            self._file = open_file(self.path, "r")
            return Content(self._file)
        except OSError as error:
            raise self._damage(error) from error

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Close it."""
        self._file.close()
        if isinstance(error, _DAMAGES):
            raise self._damage(error) from error

    def _damage(self, error: BaseException) -> PgimpError:
        if isinstance(error, OSError):
            cause = explain(error)
        elif isinstance(error, KeyError):
            cause = f"it has no {error}"
        else:
            cause = f"it is not as pgimp writes it: {' '.join(str(error).split())}"
        return RunError(f"cannot read {self.path}: {cause}")


class Content:
    """The content of an open HDF5 file itself.

    Links and datasets that lead to other files are refused: these may be untrusted, or a pipe that
    blocks.

    Parameters
    ----------
    file
        h5py.File.

    Attributes
    ----------
    attrs : mapping
        Its attributes.
    names : list of str
        Its datasets and other members.
    """

    def __init__(self, file: Any) -> None:
        self._file = file
        self.attrs = file.attrs
        self.names = list(file)

    def __getitem__(self, name: str) -> Any:
        """Return a dataset.

        Raises
        ------
        KeyError
            If there is none of this name.
        OSError
            If it is no dataset, or in another file.
        """
        h5py = load_h5py()
        if name not in self.names:
            raise KeyError(name)
        if not isinstance(self._file.get(name, getlink=True), h5py.HardLink):
            raise OSError(f"its {name} is a link to another place")
        found = self._file[name]
        if not isinstance(found, h5py.Dataset):
            raise OSError(f"its {name} is no dataset")
        if found.is_virtual or found.external:
            raise OSError(f"its {name} lies in other files")
        return found
