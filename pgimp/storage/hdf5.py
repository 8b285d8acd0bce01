"""Import of h5py without initialising MPI, and without locks of files."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from pgimp.mpi.comm import quiet_mpi
from pgimp.storage.image import Image


def load_h5py() -> ModuleType:
    """Import h5py without initialising MPI in a process without MPI.

    Returns
    -------
    module
        h5py.
    """
    if "mpi4py.MPI" not in sys.modules:
        quiet_mpi()
    import h5py

    return h5py


def open_file(path: Path | Image, mode: str, **options: Any) -> Any:
    """Open an HDF5 file from a single process, without a lock.

    HDF5's locks fail on some parallel file systems. They are not needed: files are renamed only
    when complete, and a run locks its directory.

    Parameters
    ----------
    mode : str
        As in h5py.
    **options
        Further options of h5py.File.

    Returns
    -------
    h5py.File
        The open file, in a format that HDF5 1.10 can read.
    """
    h5py = load_h5py()
    version = h5py.version.hdf5_version_tuple
    lockless = version >= (1, 10, 7) and version not in ((1, 11, 0), (1, 12, 0))
    locking = {"locking": False} if lockless else {}
    return h5py.File(path, mode, libver=("earliest", "v110"), **locking, **options)
