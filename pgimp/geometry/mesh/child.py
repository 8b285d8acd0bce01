"""Reads a mesh file in its own process, ``pgimp.geometry.mesh.child FILE BYTES SECONDS``.

Readers of dozens of formats get unchecked files. They may print, exit, loop, or allocate the sizes
in a damaged header. Here they have limits of memory and time, and a failure ends only this process.
Other files that a mesh names are opened only if they are on a disk: a pipe may never get data.
Standard output gets arrays in NumPy's format: the numbers of blocks and of groups, then points.
For each block of cells its type and the cells follow, for each group its name and the numbers of
its cells. Errors are one line on standard error.
"""

import os
import resource
import signal
import stat
import sys
from typing import IO, Any

import numpy as np

from pgimp.geometry.mesh.groups import groups_of, take_all_groups
from pgimp.geometry.mesh.ply import read_ply
from pgimp.geometry.mesh.surfaces import Read, read_obj, read_stl_text

#: Endings of formats that are HDF5, or lead to such files.
_HDF5 = (".xdmf", ".xmf", ".h5m", ".hmf", ".med", ".cgns")

#: Allowed wall time, over CPU time: a last resort if something blocks.
_PATIENCE = 5


def main() -> None:
    """Read the file that the command line names."""
    name, size, seconds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    resource.setrlimit(resource.RLIMIT_DATA, (size, size))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.alarm(_PATIENCE * seconds)
    out = os.fdopen(os.dup(1), "wb")
    silence = os.open(os.devnull, os.O_WRONLY)
    speak = os.fdopen(os.dup(2), "w", errors="replace")
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    try:
        arrays = _read(name)
    except MemoryError:
        text = "its header promises more than the file can hold, or it needs too much memory"
    except RecursionError:
        text = "it is nested too deeply"
    except SystemExit:
        text = _REASON.get("text") or "meshio cannot read it"
    except BaseException as error:  # any error of a reader is the file's fault
        text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
    else:
        for array in arrays:
            np.lib.format.write_array(_Pipe(out), array, allow_pickle=False)
        out.flush()
        os._exit(0)
    print(text, file=speak, flush=True)
    os._exit(3)


class _Pipe:
    """A stream that NumPy does not treat as a file on a disk, where it would seek."""

    def __init__(self, stream: IO[bytes]) -> None:
        self.write = stream.write


#: Text that meshio printed before it failed.
_REASON: dict[str, str] = {}


def _read(name: str) -> list[np.ndarray]:
    ending = os.path.splitext(name)[1].lower()
    if ending == ".stl" and _is_text(name):
        return _arrays(read_stl_text(name))
    if ending == ".obj":
        return _arrays(read_obj(name))
    if ending == ".ply":
        return _arrays(read_ply(name))
    import meshio

    if name.lower().endswith(_HDF5):
        _guard_hdf5()
    sys.addaudithook(_guard)

    def note(*args: object, **_: object) -> None:
        if text := " ".join(" ".join(str(a) for a in args).split()):
            _REASON["text"] = text[:300]

    meshio._helpers.print = note
    tags = take_all_groups() if ending == ".msh" else []
    mesh = meshio.read(name)
    cells = []
    for block in mesh.cells:
        kind = str(block.type)
        if kind.startswith("polyhedron"):
            cells.append((kind, np.zeros((0, 0), np.int64)))
            continue
        cells.append((kind, np.ascontiguousarray(np.asarray(block.data, np.int64))))
    points = np.ascontiguousarray(np.asarray(mesh.points, float))
    return _arrays(Read(points, cells, groups_of(mesh, tags)))


def _arrays(found: Read) -> list[np.ndarray]:
    """Arrays to send."""
    arrays = [np.array([len(found.cells), len(found.groups)]), found.points]
    for name, numbers in (*found.cells, *found.groups.items()):
        arrays += [np.array(name), numbers]
    return arrays


def _require_file(name: Any) -> None:
    """Refuse pipes and devices, which may block a reader or have no end."""
    try:
        mode = os.stat(name).st_mode
    except (OSError, ValueError, TypeError):
        return  # the reader reports it
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)) and name != os.devnull:
        raise OSError(f"it leads to {os.fsdecode(name)}, which is no regular file")


def _guard(event: str, args: tuple[object, ...]) -> None:
    """Check files that Python opens by name."""
    if event == "open" and isinstance(args[0], str | bytes):
        _require_file(args[0])


def _guard_hdf5() -> None:
    """Make h5py open only files that contain all their data."""
    import h5py

    class File(h5py.File):
        """A file whose links and data are all within it."""

        def __init__(self, name: object, *args: object, **options: object) -> None:
            _require_file(name)
            super().__init__(name, *args, **options)

            def wrong_link(path: bytes, link: Any) -> str | None:
                inside = link.type in (h5py.h5l.TYPE_HARD, h5py.h5l.TYPE_SOFT)
                return None if inside else f"its '{path.decode()}' is a link into another file"

            def wrong_data(path: bytes, about: Any) -> str | None:
                if about.type != h5py.h5o.TYPE_DATASET:
                    return None
                found = self[path]
                if not (found.external or found.is_virtual):
                    return None
                return f"the data of its '{path.decode()}' are in another file"

            # The first result ends the visit.
            wrong = self.id.links.visit(wrong_link, info=True)
            wrong = wrong or h5py.h5o.visit(self.id, wrong_data, info=True)
            if wrong:
                raise OSError(wrong)

    h5py.File = File


def _is_text(name: str) -> bool:
    """Whether an STL file is text; a truncated binary one is refused."""
    size = os.path.getsize(name)
    with open(name, "rb") as file:
        head = file.read(84)
        ascii_only = (head + file.read(1000)).isascii()
    count = int.from_bytes(head[80:], "little")
    if len(head) == 84 and size == 84 + 50 * count:
        return False
    if b"\0" not in head and (ascii_only or head.lstrip().lower().startswith(b"solid")):
        return True
    if len(head) < 84:
        raise ValueError("it is neither a text STL file nor long enough for a binary one")
    raise ValueError(
        f"its header promises {count:,} triangles, {84 + 50 * count:,} bytes, but it has "
        f"{size:,}: truncated, or no STL file"
    )


if __name__ == "__main__":
    main()
