"""Frames as files of their own: tables (CSV) of the particles, or VTU, which most readers know."""

from __future__ import annotations

import csv
from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from pgimp.errors import UsageError
from pgimp.io.results.frame import FOR_READERS, Frame, Reading, cell_fields
from pgimp.io.results.tables import absent
from pgimp.physics.fields import FROM_STRESS, components_of
from pgimp.storage.atomic import temporary, write
from pgimp.storage.plain import require_plain

Array = np.ndarray

_ROWS = 1 << 14
# meshio's name of the cell with so many vertices.
_CELLS = {1: "vertex", 2: "line", 4: "quad", 8: "hexahedron"}


def require_fields(frames: Sequence[Frame], fields: Sequence[str]) -> None:
    """Ensure that one of the frames has each of the fields, or the stress from which it follows.

    Raises
    ------
    UsageError
        With the name of the first that none has.
    """
    known = list(dict.fromkeys(name for frame in frames for name in frame.fields))
    known += [name for name in FROM_STRESS if "stress" in known and name not in known]
    for name in fields:
        if name not in known:
            raise UsageError(absent(f"field {name!r} in these frames", name, known))


def tables(folder: Path, frames: Sequence[Frame], fields: Sequence[str]) -> Iterator[Path]:
    """Write a CSV file for each frame, a line for each particle, in all digits; yield their paths.

    Parameters
    ----------
    folder : Path
        The folder for them.
    fields : sequence of str
        Fields besides `id`; those of the frame, if there are none.
    """
    for frame in frames:
        names = ["id", *(name for name in chosen(frame.fields, fields) if name != "id")]

        def fill(part: Path, frame: Frame = frame, names: Sequence[str] = names) -> None:
            with open(part, "w", encoding="utf-8", newline="") as stream:
                writer = csv.writer(stream, lineterminator="\n")
                for first in range(0, max(len(frame), 1), _ROWS):
                    last = min(first + _ROWS, len(frame))
                    read = partial(frame.rows, first=first, last=last)
                    columns = _columns({name: values(name, frame, read) for name in names})
                    if first == 0:
                        writer.writerow(columns)
                    writer.writerows(zip(*columns.values(), strict=True))

        path = folder / f"{frame.path.stem}.csv"
        replace(path, fill)
        yield path


def _columns(fields: dict[str, Array]) -> dict[str, list[float]]:
    """Columns of fields, a component each."""
    found = {}
    for name, values in fields.items():
        if values.ndim == 1:
            found[name] = values.tolist()
        else:
            parts = components_of(name, values.shape[1])
            found |= {f"{name}-{part}": values[:, i].tolist() for i, part in enumerate(parts)}
    return found


def grids(folder: Path, frames: Sequence[Frame], fields: Sequence[str]) -> Iterator[Path]:
    """Write VTU files of the frames, with those of grid, rigid bodies, surfaces; yield the paths.

    A ``.pvd`` file lists the files of each kind with their times, for ParaView.

    Parameters
    ----------
    folder : Path
        The folder for them.
    fields : sequence of str
        Fields of the particles; those of the frame, if there are none.
    """
    for kind in ("particles", "grid", "rigid", "surface"):
        listed = []
        for frame in frames:
            source = frame.path.with_name(f"{kind}-{frame.path.stem.partition('-')[2]}.h5")
            if source.exists():
                path = folder / f"{source.stem}.vtu"
                _grid(source, path, fields if kind == "particles" else ())
                listed.append((frame.time, path))
                yield path
        if listed:
            yield collection(folder / f"{kind}.pvd", listed)


def collection(path: Path, listed: Sequence[tuple[float, Path]]) -> Path:
    """Write a ``.pvd`` file that lists files of its folder with their times; return its path."""
    lines = [
        f'<DataSet timestep="{time!r}" file={quoteattr(each.name)}/>\n' for time, each in listed
    ]
    write(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
        f"{''.join(lines)}</Collection>\n</VTKFile>\n",
    )
    return path


def _grid(source: Path, path: Path, fields: Sequence[str]) -> None:
    import meshio

    with Reading(source) as file:
        names = [name for name in file.names if name not in (*FOR_READERS, "position")]
        points, cells = file["position"][()], file["connectivity"][()]
        of_cells = cell_fields(file.attrs)
        data = {
            name: values(name, names, lambda name: file[name][()]) for name in chosen(names, fields)
        }
    if cells.ndim == 1:
        cells = cells[:, None]
    cell_data = {name: [data.pop(name)] for name in of_cells}
    mesh = meshio.Mesh(points, [(_CELLS[cells.shape[1]], cells)], data, cell_data)
    replace(path, lambda part: mesh.write(part, file_format="vtu"))


def chosen(names: Sequence[str], fields: Sequence[str]) -> list[str]:
    """The fields that are there, in the order of the frame; then those that follow from them."""
    there = [name for name in names if not fields or name in fields]
    more = [name for name in FROM_STRESS if name in fields and name not in names]
    return there + (more if "stress" in names else [])


def values(name: str, there: Container[str], read: Callable[[str], Array]) -> Array:
    """Read a field, or compute it from the stress."""
    if name in there:
        return read(name)
    return FROM_STRESS[name](read("stress").astype(np.float64))


def replace(path: Path, fill: Callable[[Path], None]) -> None:
    """Write a file under a temporary name, and rename it when it is complete."""
    with suppress(FileNotFoundError):
        require_plain(path)
    part = temporary(path)
    try:
        fill(part)
        part.rename(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise
