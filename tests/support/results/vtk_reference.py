"""What h5py reads of a run's frames, for `vtk_probe.py`: vtk_reference.py DIR FILE."""

import sys
from pathlib import Path

import h5py
import numpy as np


def save(directory, path):
    """Save times and datasets of all frames as an .npz, in the order of their names."""
    values = {}
    for frame in sorted((Path(directory) / "frames").glob("*-*.h5")):
        with h5py.File(frame, locking=False) as file:
            values[f"{frame.stem}/time"] = file.attrs["time"]
            values |= {f"{frame.stem}/{k}": file[k][()] for k in file if k != "VTKHDF"}
    np.savez(path, **values)


if __name__ == "__main__":
    save(*sys.argv[1:])
