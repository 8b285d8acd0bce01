"""The state of a function of a program in a checkpoint: numbers, texts and arrays by name."""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Mapping
from typing import Any

import numpy as np

from pgimp.errors import DamagedError, RunError

#: Most bytes of a state, which is kept in the header of checkpoints.
_LARGEST = 1 << 20
_KINDS = ("<f8", "<i8", "<i4", "|b1")


def encoded(state: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return a state as JSON has it, bit for bit.

    Raises
    ------
    RunError
        If a value is of no known type, or all are too large.
    """
    found: dict[str, Any] = {}
    for name, value in state.items():
        if not isinstance(name, str):
            raise RunError(f"{where}: the state has the key {name!r}; keys are texts")
        if value is None or isinstance(value, bool | str):
            found[name] = {"plain": value}
        elif isinstance(value, int | np.integer) and abs(int(value)) < 1 << 63:
            found[name] = {"plain": int(value)}
        elif isinstance(value, float | np.floating):
            found[name] = {"number": float(value).hex()}
        elif isinstance(value, np.ndarray) and value.dtype.str in _KINDS:
            data = b64encode(np.ascontiguousarray(value).tobytes()).decode()
            found[name] = {"dtype": value.dtype.str, "shape": [*value.shape], "data": data}
        elif isinstance(value, int | np.integer):
            raise RunError(f"{where}: the state '{name}' is an integer of more than 64 bits")
        else:
            raise RunError(
                f"{where}: the state '{name}' is a {type(value).__name__}; it may have numbers, "
                "texts, None and arrays of float64, int64, int32 or bool"
            )
    if (size := sum(len(str(value)) for value in found.values())) > _LARGEST:
        raise RunError(f"{where}: the state has {size:,} bytes, of at most {_LARGEST:,}")
    return found


def decoded(stored: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state that `encoded` has stored.

    Raises
    ------
    DamagedError
        If it is none.
    """
    found: dict[str, Any] = {}
    try:
        for name, value in stored.items():
            if "plain" in value:
                found[name] = value["plain"]
            elif "number" in value:
                found[name] = float.fromhex(value["number"])
            else:
                if value["dtype"] not in _KINDS:
                    raise DamagedError(f"its state '{name}' is of an unknown type")
                flat = np.frombuffer(b64decode(value["data"]), value["dtype"])
                found[name] = flat.reshape(value["shape"]).copy()
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DamagedError(f"its state of the program is not what it must be: {error}") from None
    return found
