"""Calls in a kernel: functions of the package are inlined, others left to Numba."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from functools import cache, reduce
from types import FunctionType
from typing import Any

from numba.core.dispatcher import Dispatcher

from pgimp.jit.outside import NumbaObject
from pgimp.jit.tracing.expressions import Expressions
from pgimp.jit.tracing.frame import Frame
from pgimp.jit.tracing.source import source_of
from pgimp.jit.tracing.values import NONE, UntraceableError, Value, constant, is_tuple, tuple_of

#: Functions in functions up to this depth; a recursion ends before, when types are at their end.
_DEEPEST = 200

#: Functions whose results are computed where all their arguments are constants.
_FOLDED = (min, max, abs, int, float, bool)


class Range:
    """The numbers of a loop: begin, end and step."""

    def __init__(self, args: Sequence[Value]) -> None:
        begin = args[0] if len(args) > 1 else constant(0)
        self.bounds = begin, args[len(args) > 1], args[2] if len(args) > 2 else constant(1)


class Calls(Expressions):
    """Calls of functions."""

    _depth = 0
    #: Implementations chosen by types of arguments, and whether they may be contracted.
    _chosen: dict[tuple, tuple[FunctionType, bool]]

    def called(self, node: ast.Call, frame: Frame) -> Value:
        """Value of a call."""
        callee, args = self.expression(node.func, frame), self.listed(node.args, frame)
        named = {each.arg: self.expression(each.value, frame) for each in node.keywords}
        if not callee.known:
            raise UntraceableError("a call of what is known only when the kernel runs")
        return self._result(callee.constant, args, named)

    def _result(self, function: Any, args: list[Value], named: dict[str | None, Value]) -> Value:
        fields = getattr(function, "_fields", None)
        if fields is not None:
            given = {**dict(zip(fields, args, strict=False)), **named}
            rest = {name: constant(value) for name, value in function._field_defaults.items()}
            items = [self.typed({**rest, **given}[name]) for name in fields]
            return tuple_of(items, function)
        if isinstance(function, FunctionType) and (found := choosers(function, self.typing)):
            names = function.__code__.co_varnames[: function.__code__.co_argcount]
            args = [*args, *(named[each] for each in names[len(args) :])]
            return self.inlined(*self._implementation(function, found, args), args)
        if isinstance(function, Dispatcher) and is_traced(function):
            contracts = "contract" in (function.targetoptions.get("fastmath") or ())
            return self.inlined(function.py_func, contracts, args)
        if named:
            raise UntraceableError(f"{function} with named arguments")
        if function is range:
            return Value(None, None, Range(args))
        if function is len and is_tuple(args[0].kind):
            return constant(len(self.items(args[0])))
        if function in _FOLDED and all(each.known for each in args):
            return constant(function(*(each.constant for each in args)))
        if function in (min, max):
            values = self.items(args[0]) if len(args) == 1 else args
            return reduce(lambda one, other: self.call(function, [one, other]), values)
        return self.call(function, args)

    def _implementation(
        self, stub: FunctionType, found: Sequence[NumbaObject], args: Sequence[Value]
    ) -> tuple[FunctionType, bool]:
        """Implementation of a function for the types of arguments, and whether it contracts."""
        literal = any(each.prefer_literal for each in found)
        kinds = tuple(self.kind_of(each, literal) for each in args)
        key = stub, kinds
        if key not in self._chosen:
            for each in found:
                if (implementation := each._overload_func(*kinds)) is not None:
                    contracts = bool(each._jit_options.get("fastmath"))
                    self._chosen[key] = implementation, contracts
                    break
            else:
                raise UntraceableError(f"{stub.__qualname__} is not for {kinds}")
        return self._chosen[key]

    def inlined(self, function: FunctionType, contracts: bool, args: Sequence[Value]) -> Value:
        """Result of a function, whose instructions are emitted here."""
        node = source_of(function)
        missing = len(node.args.args) - len(args)
        defaults = function.__defaults__ or ()
        given = [*args, *(constant(each) for each in defaults[len(defaults) - missing :])]
        frame = Frame(function, node, given)
        before, self.builder.contracts = self.builder.contracts, contracts
        self._depth += 1
        if self._depth > _DEEPEST:
            raise UntraceableError("a recursion without an end")
        try:
            if isinstance(node, ast.Lambda):
                return self.expression(node.body, frame)
            return self._body(node.body, frame)
        finally:
            self.builder.contracts = before
            self._depth -= 1

    def _body(self, body: list[ast.stmt], frame: Frame) -> Value:
        found = self.block(body, frame)
        if found is not None:
            return found
        if not self.builder.block.is_terminated:
            self.leave(NONE, frame)
        self.builder.position_at_end(frame.exit)
        return self.met(frame.returned)

    def leave(self, value: Value, frame: Frame) -> None:
        """Jump to the end of the function with its result."""
        if frame.exit is None:
            frame.exit = self.new_block()
        frame.returned.append((value, self.builder.block))
        self.builder.branch(frame.exit)

    def block(self, body: Sequence[ast.stmt], frame: Frame) -> Value | None:
        """Emit statements; return the function's result if it is known at their end."""
        raise NotImplementedError


def is_traced(function: NumbaObject) -> bool:
    """Whether a compiled function is a kernel that makes no arrays."""
    options = function.targetoptions
    return "pipeline_class" in options and not options.get("_nrt", True)


@cache
def choosers(stub: FunctionType, typing: NumbaObject) -> tuple[NumbaObject, ...]:
    """What chooses implementations of a function for kernels by types; () for other functions."""
    found = getattr(typing.resolve_value_type(stub), "templates", ())
    return tuple(each for each in found if "pipeline_class" in getattr(each, "_jit_options", ()))
