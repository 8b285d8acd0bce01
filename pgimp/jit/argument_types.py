"""Types of kernels' arguments, found anew only for what has not been seen.

Numba goes through all arrays of all records, and makes a type for each before it finds that there
is one. For the arguments of a step that takes a tenth of a second, in each simulation.
"""

from typing import Any

import numba
import numpy as np

#: Types by what they follow from; tuples are known by the identities of their items' types, which
#: the type of a tuple keeps.
_KNOWN: dict[Any, Any] = {}
#: Values of these have types that follow from the class.
_PLAIN = {float, bool, np.float64, np.float32, np.int64, np.int32, np.int16, np.int8, np.uint8,
          np.bool_}  # fmt: skip


def type_of(value: Any) -> Any:
    """Numba's type of a value, the same object as from ``numba.typeof``."""
    kind = type(value)
    key: Any
    if kind is np.ndarray:
        key = value.dtype, value.ndim, value.flags.num
    elif issubclass(kind, tuple):
        key = kind, *[id(type_of(item)) for item in value]
    elif kind in _PLAIN or (
        kind is int and value.bit_length() < 63
    ):  # others are unsigned, or none
        key = kind
    else:
        return numba.typeof(value)
    found = _KNOWN.get(key)
    if found is None:
        found = _KNOWN[key] = numba.typeof(value)
    return found
