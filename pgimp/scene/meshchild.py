"""Reads a mesh file in a process of its own, ``pgimp.scene.meshchild FILE BYTES SECONDS``.

Readers of dozens of formats meet files that nobody has checked: they print, exit, allocate what a
damaged header asks for, or loop. Here they have limits of memory and time, and what goes wrong ends
this process only. Standard output gets the number of arrays and then arrays in NumPy's format:
points, and for each block of cells its type and the cells. Errors are one line on standard error.
"""

import os
import resource
import sys
from typing import IO

import numpy as np


def main() -> None:
    """Read the file that the command line names."""
    name, size, seconds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    resource.setrlimit(resource.RLIMIT_DATA, (size, size))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
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
    except BaseException as error:  # whatever a reader raises, the file is at fault
        text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
    else:
        for array in (np.array(len(arrays)), *arrays):
            np.lib.format.write_array(_Pipe(out), array, allow_pickle=False)
        out.flush()
        os._exit(0)
    print(text, file=speak, flush=True)
    os._exit(3)


class _Pipe:
    """What NumPy does not take for a file on a disk, in which it would look for its place."""

    def __init__(self, stream: IO[bytes]) -> None:
        self.write = stream.write


#: What meshio printed before it gave up.
_REASON: dict[str, str] = {}


def _read(name: str) -> list[np.ndarray]:
    if name.lower().endswith(".stl"):
        _check_stl(name)
    import meshio

    def note(*args: object, **_: object) -> None:
        if text := " ".join(" ".join(str(a) for a in args).split()):
            _REASON["text"] = text[:300]

    meshio._helpers.print = note
    mesh = meshio.read(name)
    arrays = [np.ascontiguousarray(np.asarray(mesh.points, float))]
    for block in mesh.cells:
        kind = str(block.type)
        if kind.startswith("polyhedron"):
            arrays += [np.array(kind), np.zeros((0, 0), np.int64)]
            continue
        arrays += [np.array(kind), np.ascontiguousarray(np.asarray(block.data, np.int64))]
    return arrays


def _check_stl(name: str) -> None:
    """Tell a truncated binary file from text, which meshio would take it for."""
    size = os.path.getsize(name)
    with open(name, "rb") as file:
        head = file.read(84)
        text = (head + file.read(1000)).isascii() and b"\0" not in head
    if text:
        return
    if len(head) < 84:
        raise ValueError("it is neither a text STL file nor long enough for a binary one")
    count = int.from_bytes(head[80:], "little")
    if size != 84 + 50 * count:
        raise ValueError(
            f"its header promises {count:,} triangles, {84 + 50 * count:,} bytes, but it has "
            f"{size:,}: truncated, or no STL file"
        )


if __name__ == "__main__":
    main()
