"""Values of a traced kernel: numbers and arrays of LLVM, tuples by their items, and constants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numba.core import errors, types

from pgimp.jit.outside import NumbaObject


class UntraceableError(errors.TypingError):
    """Something in a kernel that cannot be traced: what it is, and by the notes where."""


class Value:
    """A value in a kernel.

    Attributes
    ----------
    kind : Numba type or None
        None for a constant whose type nobody has asked for: a function, a class, a module.
    content : LLVM value, list of Value or None
        A list for a tuple; None for a constant.
    constant : object
        Known while tracing; `NOT_CONSTANT` for others.
    """

    __slots__ = ("constant", "content", "kind")

    def __init__(self, kind: NumbaObject, content: Any, constant: Any) -> None:
        self.kind, self.content, self.constant = kind, content, constant

    @property
    def known(self) -> bool:
        """Whether it is a constant; tuples are by their items."""
        return self.constant is not NOT_CONSTANT


class Argument(Value):
    """Number or array that a function is given; its instructions begin where it is first used.

    Attributes
    ----------
    parts : list of LLVM values
        Numbers of which it is made.
    used : bool
        Whether the function needs it.
    """

    __slots__ = ("_made", "_make", "parts", "used")

    def __init__(self, kind: NumbaObject, parts: list, make: Callable[[], Any]) -> None:
        self.kind, self.constant, self.parts, self.used = kind, NOT_CONSTANT, parts, False
        self._make, self._made = make, None

    @property
    def content(self) -> Any:  # type: ignore[override]
        """LLVM value, made at the function's beginning."""
        if self._made is None:
            self.used, self._made = True, self._make()
        return self._made


class NotConstant:
    """Mark of a value that is known only when the kernel runs."""


NOT_CONSTANT = NotConstant()
NONE = Value(types.none, None, None)


def running(kind: NumbaObject, content: Any) -> Value:
    """Value known only when the kernel runs."""
    return Value(kind, content, NOT_CONSTANT)


def constant(content: object) -> Value:
    """Value of a Python object."""
    match content:
        case None:
            return NONE
        case bool():
            return Value(types.boolean, None, content)
        case int():
            return Value(types.int64, None, content)
        case float():
            return Value(types.float64, None, content)
        case tuple():
            return tuple_of([constant(each) for each in content], _named_tuple(type(content)))
    return Value(None, None, content)


def tuple_of(items: Sequence[Value], kind: type | None = None) -> Value:
    """Tuple of typed values and objects; a NamedTuple if its class is given."""
    kinds = [types.pyobject if each.kind is None else each.kind for each in items]
    return running(types.BaseTuple.from_types(kinds, kind), [*items])


def _named_tuple(kind: type) -> type | None:
    return kind if hasattr(kind, "_fields") else None


class Range:
    """The numbers of a loop.

    Attributes
    ----------
    bounds : tuple of 3 Value
        Begin, end and step.
    """

    __slots__ = ("bounds",)
    __hash__ = None  # type: ignore[assignment]  # bounds are values of the function around it

    def __init__(self, args: Sequence[Value]) -> None:
        begin = args[0] if len(args) > 1 else constant(0)
        self.bounds = begin, args[len(args) > 1], args[2] if len(args) > 2 else constant(1)


class Cell:
    """Variable that changes in a loop: an address for each number and array of its type.

    Attributes
    ----------
    kind : Numba type
        Its type.
    addresses : LLVM value, list or None
        A list for a tuple.
    key
        What tells it from others in the kernel.
    """

    __slots__ = ("addresses", "key", "kind")

    def __init__(self, kind: NumbaObject, addresses: Any, key: tuple) -> None:
        self.kind, self.addresses, self.key = kind, addresses, key
