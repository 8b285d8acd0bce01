"""Checks of h5py: function, this file system, and an MPI library of its own."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator

from pgimp.utilities.doctor.finding import Finding
from pgimp.utilities.doctor.probe import PREAMBLE, Answer, ask, names

PROBE = f"""{PREAMBLE}
import h5py, numpy
from pgimp.storage.hdf5 import open_file
with open_file(sys.argv[1], "w") as file:
    file["x"] = numpy.arange(10.0)
lock = ""
try:
    with h5py.File(sys.argv[1]) as file:
        assert file["x"][9] == 9.0
except OSError as error:
    lock = str(error)
    with open_file(sys.argv[1], "r") as file:
        assert file["x"][9] == 9.0
print(json.dumps({{
    "version": h5py.version.version,
    "hdf5": h5py.version.hdf5_version,
    "files": mpi_libraries(),
    "lock": lock,
}}))
"""

_WHEEL = (
    "take its wheel, which has an HDF5 of its own and no MPI: "
    "pip install --force-reinstall --no-deps --only-binary=h5py h5py"
)


def examine(mpi: Answer) -> Iterator[Finding]:
    """Check h5py.

    Parameters
    ----------
    mpi : dict or str
        Findings on mpi4py, see `pgimp.utilities.doctor.mpi.PROBE`.
    """
    denied = ""
    try:
        folder = tempfile.TemporaryDirectory(dir=os.curdir, prefix=".doctor-")
    except OSError as error:
        folder, denied = tempfile.TemporaryDirectory(), os.strerror(error.errno or 0)
    with folder:
        tried = ask(PROBE, os.path.join(folder.name, "serial.h5"))
    if isinstance(tried, str):
        yield Finding("h5py", tried, _WHEEL, True)
        return
    found = f"{tried['version']}, HDF5 {tried['hdf5']}"
    own = mpi["files"] if isinstance(mpi, dict) else []
    libraries = sorted({os.path.realpath(path) for path in [*tried["files"], *own]})
    if len(libraries) > 1 and tried["files"]:
        yield Finding("h5py", f"{found}, brings in a second MPI {names(libraries)}", _WHEEL, True)
    else:
        yield Finding("h5py", found)
    if tried["lock"]:
        yield Finding(
            "file system",
            f"HDF5 cannot lock files in {os.getcwd()}: {tried['lock']}",
            "pgimp does without, but other programs cannot open the frames here until you export "
            "HDF5_USE_FILE_LOCKING=FALSE",
        )
    if denied:
        yield Finding(
            "file system",
            f"nothing can be written in {os.getcwd()} ({denied})",
            "runs go into the folder where pgimp is started; go to another one, or name one with "
            "-o DIR",
        )
