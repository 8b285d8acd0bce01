"""Words for what compiled functions return, and for why a function does not compile."""

import re

from numba.core import types

from pgimp.jit.outside import NumbaObject

_COLOUR = re.compile("\x1b\\[[0-9;]*m")
_LONGEST_MESSAGE = 600
INTEGER_HINT = "; write 0.0 for 0"


def is_tuple(kind: NumbaObject) -> bool:
    """Whether a Numba type is that of a tuple."""
    return isinstance(kind, types.BaseTuple)


def is_integer(kind: NumbaObject) -> bool:
    """Whether a Numba type is that of a whole number."""
    return isinstance(kind, types.Integer | types.IntegerLiteral)


def described(kind: NumbaObject) -> str:
    """Describe a Numba type."""
    if isinstance(kind, types.BaseTuple):
        return f"a tuple of {len(kind)}"
    for known, words in (
        (types.Optional, "None in some cases"),
        (types.NoneType, "None"),
        (types.Boolean, "a bool"),
        (types.Complex, "a complex number"),
        (types.Array, "an array"),
    ):
        if isinstance(kind, known):
            return words
    return "an int" if is_integer(kind) else "a float" if kind == types.float64 else str(kind)


def why(error: Exception) -> str:
    """Why a function does not compile, on one line."""
    text = " ".join(_COLOUR.sub("", str(error)).split())
    text = text.partition("pipeline (step: nopython frontend) ")[2] or text
    return f"{text[: _LONGEST_MESSAGE - 3]}..." if len(text) > _LONGEST_MESSAGE else text
