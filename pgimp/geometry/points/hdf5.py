"""Particles from HDF5: datasets `position`, `volume`, and optional others, block by block."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.points.block import BLOCK, STRESS, Block, States
from pgimp.geometry.points.plainhdf5 import Kind, check_dataset, find
from pgimp.geometry.points.saved import NO_BODY, Wanted, is_saved, read_saved, require_room

Reals = NDArray[np.float64]


def _kinds(D: int, states: States) -> dict[str, Kind]:
    """Kinds of the datasets; vectors and tensors may be three-dimensional, as in a run's frames."""
    vector = Kind(((D,), (3,)) if D > 1 else ((), (1,), (3,)), list(range(D)))
    square = [3 * i + j for i in range(D) for j in range(D)]
    number = Kind(((), (1,)), [0])
    tensor = Kind(((STRESS[D],), (6,)), list(range(STRESS[D])))
    return {name: tensor if states[name] else number for name in states} | {
        "position": vector,
        "volume": number,
        "velocity": vector,
        "stress": tensor,
        "velocity-gradient": Kind(((D, D), (D * D,), (3, 3), (9,)), square),
    }


def read_hdf5(
    name: str, D: int, most: int | None, states: States, wanted: Wanted | None = None
) -> Iterator[Block]:
    """Yield the particles of a file; see `pgimp.geometry.points.file.blocks`."""
    from pgimp.storage.hdf5 import load_h5py, open_file

    h5py = load_h5py()
    with open_file(Path(name), "r") as file:
        if is_saved(file):
            yield from read_saved(h5py, file, D, most, wanted)
            return
        if wanted and wanted.named:
            raise CaseError(f"it is no frame or checkpoint of a run, and has no body: {NO_BODY}")
        kinds, own = _kinds(D, states), _kinds(D, {})
        found = {key: find(h5py, file, key) for key in kinds}
        if missing := [key for key in ("position", "volume") if found[key] is None]:
            raise CaseError(f"it has no dataset {', '.join(map(repr, missing))}")
        data = {key: dataset for key, dataset in found.items() if dataset is not None}
        for key, dataset in data.items():
            check_dataset(h5py, dataset, key, kinds[key])
        count = len(data["position"])
        for key, dataset in data.items():
            if len(dataset) != count:
                raise CaseError(f"{len(dataset):,} rows of {key}, but {count:,} of position")
        require_room(count, most)
        for first in range(0, count, BLOCK):
            rows = {
                key: _rows(dataset[first : first + BLOCK], key, kinds[key], first, D)
                for key, dataset in data.items()
            }
            needed = rows["position"], rows["volume"].reshape(-1)
            given = rows.get("velocity"), rows.get("stress"), rows.get("velocity-gradient")
            state = {name: rows[name] for name in states if name in rows and name not in own}
            yield Block(
                first, *needed, *given, state, lambda row, k=first: f"row {k + row} (from 0)"
            )


def _rows(values: Any, key: str, kind: Kind, first: int, D: int) -> Reals:
    """Rows of a dataset in the case's dimension; nonzero components beyond it are refused."""
    table = np.asarray(values, float).reshape(len(values), -1)
    if table.shape[1] <= len(kind.kept):
        return table
    beyond = np.ones(table.shape[1], bool)
    beyond[kind.kept] = False
    if len(bad := np.flatnonzero((table[:, beyond] != 0.0).any(axis=1))):
        raise CaseError(
            f"row {first + bad[0]} (from 0): {key} has a part along a direction that the case, "
            f"{D}D, does not have"
        )
    return np.ascontiguousarray(table[:, kind.kept])
