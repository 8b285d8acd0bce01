"""The XDMF file that shows all frames of a run to ParaView as one series in time."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import ClassVar

from pgimp.io.frames.mesh import Mesh
from pgimp.io.frames.writer import Writer
from pgimp.storage.atomic import write

_NUMBER_TYPE = {"f": "Float", "i": "Int"}

#: Type of the cells with so many vertices.
_CELLS = {1: "Polyvertex", 2: "Polyline", 4: "Quadrilateral", 8: "Hexahedron"}


class Collection(Writer):
    """A temporal collection of frames, complete after each frame.

    ParaView has three readers of XDMF, which agree only on a subset: cells by an explicit
    connectivity dataset, six-component tensors as a matrix, whole datasets.

    Parameters
    ----------
    path : Path
        The file; its name without suffix is the collection's.
    """

    suffix: ClassVar[str] = ".xdmf"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._grids: list[str] = []

    def add(self, mesh: Mesh) -> None:
        """See `Writer.add`."""
        self._grids.append(_grid(mesh))

    def finish(self, last: bool = False) -> None:
        """See `Writer.finish`."""
        self.write(durable=last)

    def restart(self) -> None:
        """See `Writer.restart`."""
        self.write()

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


def _grid(mesh: Mesh) -> str:
    """Text of a frame."""
    file, nodes = mesh.relative, mesh.nodes
    lines = [
        f'<Grid Name="{mesh.series}" GridType="Uniform">',
        f'<Time Value="{mesh.time!r}"/>',
        f'<Topology TopologyType="{_CELLS[nodes]}" NumberOfElements="{mesh.cells}" '
        f'NodesPerElement="{nodes}">',
        _item(file, "connectivity", "<i8", mesh.cells, 0 if nodes == 1 else nodes),
        "</Topology>",
        '<Geometry GeometryType="XYZ">',
        _item(file, "position", mesh.fields["position"].dtype, mesh.points, 3),
        "</Geometry>",
    ]
    for name, field in mesh.fields.items():
        if name == "position":
            continue
        lines += [
            f'<Attribute Name="{escape(name)}" AttributeType="{field.kind}" '
            f'Center="{"Cell" if name in mesh.of_cells else "Node"}">',
            _item(file, name, field.dtype, mesh.rows(name), field.columns),
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
