"""The XDMF file that shows all frames of a run to ParaView as one series in time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

from pgimp.output.fields import EVERY
from pgimp.output.files import write

_NUMBER_TYPE = {"f": "Float", "i": "Int"}


class Collection:
    """A temporal collection of particle frames, whole again after each frame.

    ParaView has three readers of XDMF, and this is what all of them read alike: cells by an
    explicit connectivity dataset, six-component tensors as a matrix, whole datasets only.

    Parameters
    ----------
    path : Path
        The file; frames are named relative to its folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._grids: list[str] = []

    def add(self, frame: Path, time: float, count: int, types: Mapping[str, str]) -> None:
        """Add a frame.

        Parameters
        ----------
        frame : Path
            The frame's file.
        time : float
            Its simulated time.
        count : int
            Its number of particles.
        types : mapping of str to str
            Its fields, `position` among them, and their types.
        """
        name = frame.relative_to(self.path.parent).as_posix()
        self._grids.append(_grid(name, time, count, types))

    def write(self, durable: bool = False) -> None:
        """Write the file anew, with all frames so far.

        Parameters
        ----------
        durable : bool
            Whether it must outlast a crash of the machine; until the last frame, the file can be
            made again.

        Raises
        ------
        OSError
            If it cannot be written; the older version then stays.
        """
        write(
            self.path,
            '<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n'
            '<Grid Name="particles" GridType="Collection" CollectionType="Temporal">\n'
            f"{''.join(self._grids)}</Grid>\n</Domain>\n</Xdmf>\n",
            durable,
        )


def _grid(file: str, time: float, count: int, types: Mapping[str, str]) -> str:
    lines = [
        '<Grid Name="particles" GridType="Uniform">',
        f'<Time Value="{time!r}"/>',
        f'<Topology TopologyType="Polyvertex" NumberOfElements="{count}" NodesPerElement="1">',
        _item(file, "connectivity", "<i8", count, 0),
        "</Topology>",
        '<Geometry GeometryType="XYZ">',
        _item(file, "position", types["position"], count, 3),
        "</Geometry>",
    ]
    for name, dtype in types.items():
        field = EVERY[name]
        if name == "position":
            continue
        lines += [
            f'<Attribute Name={quoteattr(name)} AttributeType="{field.kind}" Center="Node">',
            _item(file, name, dtype, count, field.columns),
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
