"""Checkpoint files of known content, on any number of ranks, and whether they come back."""

import h5py
import numpy as np

from pgimp.io.checkpoints.checkpointfile import CheckpointFile, write

ABOUT = {"time": 0.1 + 0.2, "zero": -0.0, "step": 7, "title": 'Fülle "\\ud83d"\n', "none": [None]}


def content(count, seed=5):
    random = np.random.default_rng(seed)
    rows = {
        "id": random.permutation(count),
        "x": random.normal(size=(count, 3)),
        "body": random.integers(9, size=count).astype(np.int32),
        "F": random.normal(size=(count, 2, 2)),
        "none": np.zeros((count, 0)),
    }
    if count:
        rows["x"][0] = [np.nan, -0.0, np.inf]
    whole = {"layers": np.arange(6), "work": random.normal(size=(3, 2)), "s": np.array(2.5)}
    return rows, whole | {"empty": np.zeros((0, 3))}


def write_on(comm, path, count, empty=(1,), seed=5):
    """Write with the rows spread over the ranks; those in `empty` get none."""
    rows, whole = content(count, seed)
    shares = np.array([0 if rank in empty else rank + 1 for rank in range(comm.size)])
    bounds = [0, *(np.cumsum(shares) * count // max(1, shares.sum()))]
    mine = {name: a[bounds[comm.rank] : bounds[comm.rank + 1]] for name, a in rows.items()}
    about, whole = (ABOUT, whole) if comm.rank == 0 else ({}, {})
    write(path, comm, about, mine, whole)


def check_content(path, count, parts=2, seed=5):
    """The file holds the rows, read in as many parts, and h5py sees the same."""
    rows, whole = content(count, seed)
    file = CheckpointFile(path)
    assert file.about == ABOUT and file.count == count and np.signbit(file.about["zero"])
    assert file.rows == {name: (a.dtype, a.shape[1:]) for name, a in rows.items()}
    assert file.whole == {name: (a.dtype, a.shape) for name, a in whole.items()}
    bounds = [part * count // parts for part in range(parts + 1)]
    for part in range(parts):
        file.verify(part, parts)
        for name, array in rows.items():
            wanted = array[bounds[part] : bounds[part + 1]]
            found = file.read(name, *bounds[part : part + 2])
            assert (found.dtype, found.shape) == (wanted.dtype, wanted.shape)
            assert found.tobytes() == wanted.tobytes()
    for name, array in whole.items():
        assert file.read_whole(name).tobytes() == array.tobytes()
        assert file.read_whole(name).shape == array.shape
    with h5py.File(path) as hdf5:
        assert set(hdf5) == {*rows, *whole} and hdf5.userblock_size >= 512
        for name, array in (rows | whole).items():
            assert hdf5[name].shape == array.shape and hdf5[name].dtype == array.dtype
            assert hdf5[name][()].tobytes() == array.tobytes()
