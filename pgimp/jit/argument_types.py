"""Types of kernels' arguments, found anew only for what has not been seen.

Numba goes through all arrays of all records, and makes a type for each before it finds that there
is one. For the arguments of a step that takes a tenth of a second, in each simulation.
"""

from typing import Any

import numba
import numpy as np

#: Types by what they follow from. Tuples are known by the identities of their items' types; these
#: are kept beside, so that no other type ever has one of them.
_KNOWN: dict[Any, tuple[Any, list]] = {}
#: Values of these have types that follow from the class.
_PLAIN = {float, bool, np.float64, np.float32, np.int64, np.int32, np.int16, np.int8, np.uint8,
          np.bool_}  # fmt: skip


def type_of(value: Any) -> Any:
    """Numba's type of a value, the same object as from ``numba.typeof``."""
    kind = type(value)
    key: Any
    items: list = []
    if kind is np.ndarray:
        key = value.dtype, value.ndim, value.flags.num
    elif issubclass(kind, tuple):
        items = [type_of(item) for item in value]
        key = kind, *map(id, items)
    elif kind in _PLAIN or (kind is int and value.bit_length() < 63):
        key = kind
    else:  # greater integers are unsigned, or have no type
        return numba.typeof(value)
    found = _KNOWN.get(key)
    if found is None:
        found = _KNOWN[key] = numba.typeof(value), items
    return found[0]
