"""Messages and bytes that ranks send, counted between pgimp and MPI.

A small library, preloaded, stands in for MPI's sending functions (messages.c). It sees every call,
whether mpi4py sends a buffer, a persistent request, or an object.
"""

import ctypes
import subprocess
from pathlib import Path

import numpy as np


def counting(folder):
    """Build the library in a folder; returns the environment in which ranks count."""
    library = Path(folder).resolve() / "messages.so"
    source = Path(__file__).with_name("messages.c")
    words = ["mpicc", "-O1", "-shared", "-fPIC", "-o", str(library), str(source)]
    subprocess.run(words, check=True)
    return {"LD_PRELOAD": str(library)}


def sent():
    """What this rank has sent until now: messages, bytes, reductions, bytes; (4,) int64."""
    return np.array((ctypes.c_longlong * 4).in_dll(ctypes.CDLL(None), "pgimp_sent"), np.int64)
