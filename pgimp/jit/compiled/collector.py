"""The garbage collector while kernels are compiled."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def spared() -> Iterator[None]:
    """Spare the objects that exist by now from garbage collection.

    Numba creates so many objects that all modules would be searched for garbage again and again:
    a seventh of the time in which kernels are compiled.
    """
    if gc.get_freeze_count():  # the program that imports pgimp does it itself
        yield
        return
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
