"""The XDMF file that shows all frames of a run to ParaView as one series in time."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path

from pgimp.physics.fields import Field
from pgimp.storage.atomic import write

Kind = tuple[str, int, str]
"""Of a field: its attribute type, number of columns (0 for a scalar) and type in the file."""

_NUMBER_TYPE = {"f": "Float", "i": "Int"}


class Collection:
    """A temporal collection of frames, complete after each frame.

    ParaView has three readers of XDMF, which agree only on a subset: cells by an explicit
    connectivity dataset, six-component tensors as a matrix, whole datasets.

    Parameters
    ----------
    path : Path
        The file; its name without suffix is the collection's.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._grids: list[str] = []

    def add(self, grid: str) -> None:
        """Add a frame, the text from `particles` or `mesh`."""
        self._grids.append(grid)

    def write(self, durable: bool = False) -> None:
        """Rewrite the file with all frames so far.

        Parameters
        ----------
        durable : bool
            Whether it must survive a crash of the machine; before the last frame it can be rebuilt.

        Raises
        ------
        OSError
            If it cannot be written; the older version then stays.
        """
        write(
            self.path,
            '<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n'
            f'<Grid Name="{self.path.stem}" GridType="Collection" CollectionType="Temporal">\n'
            f"{''.join(self._grids)}</Grid>\n</Domain>\n</Xdmf>\n",
            durable,
        )


def particles(
    path: Path, time: float, count: int, types: Mapping[str, str], kinds: Mapping[str, Field]
) -> str:
    """Return the XDMF text of a frame of particles.

    Parameters
    ----------
    path : Path
        The frame's file; the XDMF file is in the folder above or beside it.
    time : float
        Simulated time.
    count : int
        Number of particles.
    types : mapping of str to str
        Fields, including `position`, and their types.
    kinds : mapping of str to Field
        Definition of each field.
    """
    file = relative(path)
    topology = 'TopologyType="Polyvertex"', 1
    fields = {name: (kinds[name].kind, kinds[name].columns, types[name]) for name in types}
    return _grid("particles", file, time, (count, count), topology, fields)


#: Type of the cells of a grid, by dimension, with its attribute.
_CELLS = ('TopologyType="Polyline"', 'TopologyType="Quadrilateral"', 'TopologyType="Hexahedron"')


def mesh(
    path: Path, time: float, counts: tuple[int, int], dimension: int, fields: Mapping[str, Kind]
) -> str:
    """Return the XDMF text of a frame of the grid.

    Parameters
    ----------
    path : Path
        The frame's file.
    time : float
        Its simulated time.
    counts : (int, int)
        Numbers of vertices and of cells.
    dimension : int
        1, 2 or 3.
    fields : mapping of str to (str, int, str)
        Fields, including `position`: attribute type, columns (0 for a scalar), type.
    """
    topology = _CELLS[dimension - 1], 2**dimension
    return _grid("grid", relative(path), time, counts, topology, fields)


def surface(path: Path, time: float, counts: tuple[int, int], dimension: int) -> str:
    """Return the XDMF text of a frame of the rigid bodies; as `mesh`, for cells of surfaces."""
    fields: dict[str, Kind] = {"position": ("Vector", 3, "<f8"), "body": ("Scalar", 0, "<i8")}
    topology = ('TopologyType="Polyvertex"', *_CELLS)[dimension - 1], 2 ** (dimension - 1)
    return _grid("rigid", relative(path), time, counts, topology, fields)


def relative(path: Path) -> str:
    """Return the name of a frame in the files that list all of them."""
    return f"{path.parent.name}/{path.name}" if path.parent.name == "frames" else path.name


def _grid(
    name: str,
    file: str,
    time: float,
    counts: tuple[int, int],
    topology: tuple[str, int],
    fields: Mapping[str, Kind],
) -> str:
    vertices, cells = counts
    kind, nodes = topology
    columns = 0 if nodes == 1 else nodes
    lines = [
        f'<Grid Name="{name}" GridType="Uniform">',
        f'<Time Value="{time!r}"/>',
        f'<Topology {kind} NumberOfElements="{cells}" NodesPerElement="{nodes}">',
        _item(file, "connectivity", "<i8", cells, columns),
        "</Topology>",
        '<Geometry GeometryType="XYZ">',
        _item(file, "position", fields["position"][2], vertices, 3),
        "</Geometry>",
    ]
    for field, (attribute, width, dtype) in fields.items():
        if field == "position":
            continue
        lines += [
            f'<Attribute Name="{escape(field)}" AttributeType="{attribute}" Center="Node">',
            _item(file, field, dtype, vertices, width),
            "</Attribute>",
        ]
    return "\n".join([*lines, "</Grid>\n"])


def _item(file: str, name: str, dtype: str, count: int, columns: int) -> str:
    shape = f"{count} {columns}" if columns else str(count)
    kind, precision = _NUMBER_TYPE[dtype[1]], dtype[2]
    return (
        f'<DataItem Format="HDF" NumberType="{kind}" Precision="{precision}" '
        f'Dimensions="{shape}">{file}:/{name}</DataItem>'
    )
