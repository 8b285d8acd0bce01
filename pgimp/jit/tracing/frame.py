"""The function that is being inlined: its names, and where it ends."""

from __future__ import annotations

import builtins
from types import FunctionType
from typing import Any

from pgimp.jit.outside import NumbaObject
from pgimp.jit.tracing.source import Function
from pgimp.jit.tracing.values import Cell, UntraceableError, Value, constant


class Frame:
    """A function that is being inlined.

    Attributes
    ----------
    names : dict
        Its variables.
    cells : dict
        Variables that change in the loops around the present statement; None before their first
        value.
    kept_by : dict
        The line of the loop that made each of them.
    loops : list
        Blocks where each of these loops goes on, and where it ends.
    depth : int
        Number of branches and loops around the present statement.
    exit
        The block after the function, if anything jumps there.
    returned : list
        Results, and the blocks that jump there.
    owned : list
        Types and addresses of the arrays that it makes.
    """

    def __init__(self, function: FunctionType, node: Function, args: list[Value]) -> None:
        self.function, self.node = function, node
        self.names: dict[str, Value | Cell | None] = dict(
            zip([each.arg for each in node.args.args], args, strict=True)
        )
        self.cells: dict[str, Cell | None] = {}
        self.kept_by: dict[str, int] = {}
        self.loops: list[tuple[Any, Any]] = []
        self.depth = 0
        self.exit: Any = None
        self.returned: list[tuple[Value, Any]] = []
        self.owned: list[tuple[NumbaObject, Any]] = []
        self._key = function.__code__, tuple(map(_what, args))

    def key(self, name: str, line: int) -> tuple[Any, ...]:
        """What tells a variable of the loop at a line from others, also by types and functions."""
        return *self._key, name, line

    def outer(self, name: str) -> Value:
        """Value of a name that is no variable of the function."""
        function = self.function
        free = function.__code__.co_freevars
        if name in free:
            return constant((function.__closure__ or ())[free.index(name)].cell_contents)
        for space in (function.__globals__, vars(builtins)):
            if name in space:
                return constant(space[name])
        raise UntraceableError(f"{name} has no value")


def _what(value: Value) -> Any:
    """What decides about the types of variables in a function that is given a value."""
    found = getattr(value.constant, "py_func", value.constant)
    return getattr(found, "__code__", found if isinstance(found, type | str) else value.kind)
