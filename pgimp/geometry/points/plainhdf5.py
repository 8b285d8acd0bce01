"""Datasets of a user's HDF5 file, found without opening any other file."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pgimp.errors import CaseError
from pgimp.schema.messages import shorten

#: The largest chunk of a dataset [bytes].
_CHUNK = 256_000_000


class Kind(NamedTuple):
    """Allowed shapes of a dataset's row, and the components of it that the case has."""

    shapes: tuple[tuple[int, ...], ...]
    kept: list[int]


#: Most links in a chain; a longer chain counts as a circle.
_MOST_LINKS = 16


def find(h5py: Any, file: Any, key: str) -> Any:
    """Return the object at a path; None if the file has none.

    HDF5 would follow links into other files and read them. These may be a pipe without a writer,
    a device, or on a missing disk.

    Parameters
    ----------
    h5py : module
        From `pgimp.storage.hdf5.load_h5py`.
    file : h5py.File
        Open.
    key : str
        Path from its root.

    Raises
    ------
    CaseError
        If a link leads to another file, to nowhere or in a circle, or if the data are in another
        file.
    """
    parts, group, links = key.strip("/").split("/"), file["/"], 0
    while parts:
        name = parts.pop(0).encode()
        if name in (b"", b"."):
            continue
        if not isinstance(group, h5py.Group) or not group.id.links.exists(name):
            if links:
                raise CaseError(f"'{key}' is a link to nowhere")
            return None
        kind = group.id.links.get_info(name).type
        if kind == h5py.h5l.TYPE_SOFT:
            links += 1
            if links > _MOST_LINKS:
                raise CaseError(f"'{key}' is a link that leads in a circle")
            target = group.id.links.get_val(name).decode(errors="replace")
            group = file["/"] if target.startswith("/") else group
            parts = target.strip("/").split("/") + parts
        elif kind == h5py.h5l.TYPE_HARD:
            group = group[name]
        else:
            other = b"another file"
            if kind == h5py.h5l.TYPE_EXTERNAL:
                other = b"the file " + group.id.links.get_val(name)[0]
            raise CaseError(
                f"'{key}' is a link into {shorten(other.decode(errors='replace'), 200)}; copy the "
                "data into this one"
            )
    if isinstance(group, h5py.Dataset):
        if group.external:
            other_file = shorten(str(group.external[0][0]), 200)
            raise CaseError(
                f"the data of '{key}' are in another file, {other_file}; "
                "copy them into this one (h5repack)"
            )
        if group.is_virtual:
            raise CaseError(f"'{key}' is a view of other datasets; copy the data into this one")
    return group


def check_dataset(h5py: Any, data: Any, key: str, kind: Kind) -> None:
    """Check the type and shape of a dataset."""
    if not isinstance(data, h5py.Dataset) or data.dtype.kind not in "fiu":
        raise CaseError(f"'{key}' is no dataset of numbers")
    if data.ndim == 0 or data.shape[1:] not in kind.shapes:
        shapes = dict.fromkeys(kind.shapes)
        wanted = " or ".join(str(("n", *shape)).replace("'", "") for shape in shapes)
        raise CaseError(f"'{key}' has the shape {data.shape}; expected {wanted}")
    if data.chunks and np.prod(data.chunks, dtype=float) * data.dtype.itemsize > _CHUNK:
        raise CaseError(f"'{key}' is stored in chunks of {data.chunks}; use smaller ones")
