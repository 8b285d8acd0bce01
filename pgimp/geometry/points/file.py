"""The user's own particles, read block by block from an HDF5, a CSV or a VTK file.

HDF5: datasets `position` (n, D), `volume` (n,), and optionally `velocity` (n, D), `stress` (n, 6),
`velocity-gradient` (n, D, D). Vectors and tensors may have the components of 3D in any dimension,
as in the frames of a run. CSV: a line of names, `x, y, z, volume, velocity-x, ..., stress-xx, ...,
velocity-gradient-xx, -xy, ...`, then a line for each particle. Empty lines and comments (#) are
skipped. VTU and VTP: arrays at points, by the names of the datasets. All may have the state
variables of the body's material by their names. A frame or a checkpoint of a run has the whole
state, see `pgimp.geometry.points.saved`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pgimp.errors import CaseError
from pgimp.geometry.mesh.file import check_file
from pgimp.geometry.points.block import Block, States
from pgimp.geometry.points.csv import read_csv
from pgimp.geometry.points.hdf5 import read_hdf5
from pgimp.geometry.points.saved import NO_BODY, Wanted
from pgimp.geometry.points.vtk import read_vtk
from pgimp.schema.messages import shorten


def blocks(
    name: str,
    dimensions: int,
    most: int | None = None,
    states: States | None = None,
    wanted: Wanted | None = None,
) -> Iterator[Block]:
    """Yield the particles of a file.

    Parameters
    ----------
    name : str
        The file.
    dimensions : int
        Dimensions of the case.
    most : int, optional
        Particles that memory can hold; a file that claims more is refused before it is read.
    states : mapping of str to bool, optional
        State variables that the file may give, see `pgimp.geometry.points.block`.
    wanted : Wanted, optional
        What the body needs of a frame or a checkpoint of a run.

    Raises
    ------
    CaseError
        With the file, the row and the problem.
    """
    check_file(name, "the particles")
    ending = Path(name).suffix.lower()
    if ending in (".h5", ".hdf5"):
        found = read_hdf5(name, dimensions, most, states or {}, wanted)
    elif ending in (".vtu", ".vtp"):
        if wanted and wanted.named:
            raise CaseError(f"cannot use the particles {name}: VTK knows no body: {NO_BODY}")
        found = read_vtk(name, dimensions, most, states or {})
    elif ending in (".csv", ".txt"):
        if wanted and wanted.named:
            raise CaseError(f"cannot use the particles {name}: a table has no body: {NO_BODY}")
        found = read_csv(name, dimensions, states or {})
    else:
        raise CaseError(
            f"cannot read the particles {name}: its name must end in .h5, .hdf5, .csv, .vtu or "
            f".vtp, not '{shorten(ending)}'"
        )
    try:
        yield from found
    except CaseError as error:
        raise CaseError(f"cannot use the particles {name}: {error}") from None
    except (
        OSError,
        RuntimeError,
        UnicodeDecodeError,
        KeyError,
        ValueError,
        MemoryError,
        TypeError,
    ) as error:
        text = shorten(str(error), 200) or type(error).__name__
        raise CaseError(
            f"cannot read the particles {name}: {text}; it is damaged or no file of its kind: "
            "write it again"
        ) from None
