"""Points and cells of a mesh file, read by meshio in a process with limits."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.schema.messages import shorten
from pgimp.storage.plain import open_plain

#: Limits of memory [bytes] and time [s] for reading: constant, and per byte of the file.
_MEMORY, _TIME = (1_500_000_000, 40), (60, 4e-6)

_LAUNCHERS = ("OMPI_", "PMIX_", "PMI_", "PALS_", "MPI_LOCAL")


class RawMesh(NamedTuple):
    """Content of a mesh file."""

    points: NDArray[np.float64]  #: (n, d) float64.
    #: list of (str, (m, k) int64): Blocks of cells by type.
    cells: list[tuple[str, NDArray[np.int64]]]
    #: dict of str to (c,) int64: Numbers of cells, over all blocks, by the names of groups.
    groups: dict[str, NDArray[np.int64]]


def check_file(name: str, what: str) -> int:
    """Return the size of a readable file.

    Raises
    ------
    CaseError
        If it is missing, no regular file, empty, or must not be read.
    """
    try:
        with open_plain(name) as stream:
            size = os.fstat(stream.fileno()).st_size
    except OSError as error:
        raise CaseError(
            f"cannot read {what} {name}: {error.strerror or error}; a relative name starts from "
            "the folder of the case file"
        ) from None
    except ValueError as error:
        raise CaseError(f"cannot read {what} {name!r}: {error}") from None
    if size == 0:
        raise CaseError(f"cannot read {what} {name}: it is empty")
    return size


def read_mesh(name: str) -> RawMesh:
    """Read a mesh file of any format that meshio recognises by its file name's suffix.

    Raises
    ------
    CaseError
        With the file, the problem and a remedy.
    """
    size = check_file(name, "the mesh")
    memory = _MEMORY[0] + _MEMORY[1] * size
    seconds = round(_TIME[0] + _TIME[1] * size)
    env = {k: v for k, v in os.environ.items() if not k.startswith(_LAUNCHERS)}
    root = str(Path(__file__).resolve().parents[3])
    env["PYTHONPATH"] = os.pathsep.join(filter(None, (root, env.get("PYTHONPATH"))))
    env |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "HDF5_USE_FILE_LOCKING": "FALSE"}
    child_module = "pgimp.geometry.mesh.child"
    words = [sys.executable, "-P", "-m", child_module, name, str(memory), str(seconds)]
    with subprocess.Popen(
        words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=env
    ) as child:
        try:
            assert child.stdout is not None
            assert child.stderr is not None
            arrays = _arrays(child.stdout)
            said = child.stderr.read(10_000).decode(errors="replace").strip()
            status = child.wait()
        except BaseException:
            child.kill()
            raise
    if arrays is None or status != 0:
        raise CaseError(f"cannot read the mesh {name}: {_cause(name, status, said)}")
    points, *pairs = arrays[1:]
    named = [(str(name), values) for name, values in zip(pairs[::2], pairs[1::2], strict=True)]
    blocks = int(arrays[0][0])
    return RawMesh(points, named[:blocks], dict(named[blocks:]))


class _Pipe:
    """A stream that NumPy does not treat as a file on a disk, where it would seek."""

    def __init__(self, stream: IO[bytes]) -> None:
        self.read = stream.read


def _arrays(stream: IO[bytes]) -> list[np.ndarray] | None:
    """Arrays sent by the child; None if it has failed."""

    def one() -> np.ndarray:
        return np.lib.format.read_array(_Pipe(stream), allow_pickle=False)

    try:
        counts = one()
        return [counts, *(one() for _ in range(1 + 2 * int(counts.sum())))]
    except (ValueError, EOFError, OSError):
        return None


def _cause(name: str, status: int, said: str) -> str:
    """Describe the cause of a failed read."""
    if status < 0:
        return f"its reader was ended by signal {-status}: too much time or memory, or a crash"
    if "Could not deduce file format" in said or not Path(name).suffix:
        return (
            f"meshio knows no format '{shorten(Path(name).suffix)}'; use .stl, .obj, .ply, .msh, "
            ".vtu, .vtk or another that meshio reads"
        )
    line = shorten(said.splitlines()[-1], 300) if said else "it is damaged"
    return f"{line}; export it again, or in another format (.vtu, .ply, binary .stl)"
