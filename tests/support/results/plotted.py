"""What runs hold, read without pgimp, and the tables of ``pgimp plot``."""

import csv
import shutil

import h5py
import numpy as np


def table(path):
    """A CSV as columns of text by name."""
    rows = list(csv.reader(path.read_text().splitlines()))
    return dict(zip(rows[0], zip(*rows[1:], strict=True), strict=True))


def numbers(columns, name):
    return np.array(columns[name], dtype=float)


def hdf5(runs, name, number=-1):
    """The fields of a frame, by h5py alone."""
    path = sorted((runs / name / "frames").glob("particles-*.h5"))[number]
    with h5py.File(path) as file:
        return {key: file[key][:] for key in file if key != "VTKHDF"}


def history(runs, name):
    return np.genfromtxt(runs / name / "history.csv", delimiter=",", names=True, deletechars="")


def invented(runs, folder, name, **columns):
    """A run directory with a history of one's own."""
    directory = folder / f"{name}.out"
    directory.mkdir()
    for file in ("case.yaml", "run.json"):
        shutil.copy(runs / "plates.out" / file, directory)
    columns = {"time": [0.0, 0.5, 1.0], "step": [0, 1, 2]} | columns
    rows = [columns, *zip(*columns.values(), strict=True)]
    (directory / "history.csv").write_text("".join(f"{','.join(map(str, r))}\n" for r in rows))
