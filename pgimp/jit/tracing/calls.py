"""Calls in a kernel: functions of the package are inlined, others left to Numba."""

from __future__ import annotations

import ast
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import cache, partial, reduce
from math import isqrt
from types import BuiltinFunctionType, FunctionType, ModuleType, NoneType
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.dispatcher import Dispatcher
from numpy import ndarray

from pgimp.jit.outside import NumbaObject
from pgimp.jit.results import is_tuple
from pgimp.jit.tracing.frame import Frame
from pgimp.jit.tracing.functions import Functions, is_object
from pgimp.jit.tracing.source import source_of
from pgimp.jit.tracing.values import NONE, Range, UntraceableError, Value, constant, tuple_of

#: Functions in functions up to this depth; a recursion ends before, when types are at their end.
_DEEPEST = 200

#: Functions whose results are computed where all their arguments are constants.
_FOLDED = (min, max, abs, int, float, bool, isqrt, len)

#: Functions of generators: the operation between items, and the result without any.
_GENERATED = {
    "tuple": (ast.Add(), ()), "sum": (ast.Add(), 0),
    "any": (ast.BitOr(), False), "all": (ast.BitAnd(), True),
}  # fmt: skip


class Calls(Functions):
    """Calls of functions."""

    def __init__(
        self, typing: NumbaObject, context: NumbaObject, module: ir.Module, widened: dict
    ) -> None:
        super().__init__(typing, context, module, widened)
        # Implementations by types of arguments, and their options.
        self._chosen: dict[tuple, tuple[FunctionType, dict] | None] = {}

    def called(self, node: ast.Call, frame: Frame) -> Value:
        """Value of a call."""
        if isinstance(node.func, ast.Name) and node.args:
            if node.func.id in _GENERATED and isinstance(node.args[0], ast.GeneratorExp):
                items = [self.typed(each) for each in self._generated(node.args[0], frame)]
                if node.func.id == "tuple":
                    return tuple_of(items)
                if node.func.id == "sum":
                    begin = [*node.args[1:], *(each.value for each in node.keywords)]
                    items = [*self.listed(begin, frame), *items]
                if node.func.id != "sum":
                    items = [self.truth(each) for each in items]
                operation, first = _GENERATED[node.func.id]
                return reduce(partial(self.operation, operation), items or [constant(first)])
        if isinstance(node.func, ast.Attribute):
            owner = self.expression(node.func.value, frame)
            if isinstance(owner.kind, types.Array) and not owner.known:
                return self.call(node.func.attr, self.listed(node.args, frame), owner)
            callee = self.attribute(owner, node.func.attr)
        else:
            callee = self.expression(node.func, frame)
        args = self.listed(node.args, frame)
        named = {each.arg: self.expression(each.value, frame) for each in node.keywords}
        if not callee.known:
            raise UntraceableError("a call of what is known only when the kernel runs")
        return self._result(callee.constant, args, named)

    def _generated(self, node: ast.GeneratorExp, frame: Frame) -> list[Value]:
        """Values of an expression for each item of tuples, or each number of known ranges."""
        before = dict(frame.names), frame.cells
        frame.cells = {}  # its names are its own
        found = self._values(node.elt, node.generators, frame)
        frame.names, frame.cells = before
        return found

    def _values(
        self, wanted: ast.expr, loops: Sequence[ast.comprehension], frame: Frame
    ) -> list[Value]:
        if not loops:
            return [self.expression(wanted, frame)]
        over, found = self.expression(loops[0].iter, frame), []
        if isinstance(over.constant, Range):
            items = [constant(i) for i in range(*(each.constant for each in over.constant.bounds))]
        else:
            items = self.items(over)
        for item in items:
            self.assign(loops[0].target, item, frame)
            tests = [self.condition(each, frame) for each in loops[0].ifs]
            if not all(each.known for each in tests):
                raise UntraceableError("items of a generator by what only the run knows")
            if all(each.constant for each in tests):
                found += self._values(wanted, loops[1:], frame)
        return found

    def assign(self, target: ast.expr, value: Value, frame: Frame) -> None:
        """Give a value to names, or to what is in an array or a record."""
        raise NotImplementedError

    def _result(self, function: Any, args: list[Value], named: dict[str | None, Value]) -> Value:
        fields = getattr(function, "_fields", None)
        if fields is not None:
            items = in_order(function.__name__, fields, function._field_defaults, args, named)
            return tuple_of([*map(self.typed, items)], function)
        is_pythons = function is hasattr or not is_known(function, self.typing)
        if (
            is_pythons
            and not named
            and all(each.known for each in args)
            and (any(map(is_object, args)) or is_method(function))
        ):
            return constant(function(*(each.constant for each in args)))
        python = getattr(function, "py_func", function)
        if named and isinstance(python, FunctionType):
            names = python.__code__.co_varnames[: python.__code__.co_argcount]
            defaults = python.__defaults__ or ()
            known = dict(zip(names[len(names) - len(defaults) :], defaults, strict=True))
            args, named = in_order(python.__qualname__, names, known, args, named), {}
        if isinstance(function, FunctionType):
            if hasattr(function, "of_types"):
                kinds = (each.constant if is_object(each) else self.kind_of(each) for each in args)
                return constant(function(*kinds))
        if isinstance(function, Dispatcher) and is_traced(function):
            contracts = "contract" in (function.targetoptions.get("fastmath") or ())
            if function.targetoptions.get("no_cpython_wrapper"):
                return self.outlined(function, contracts, args)
            return self.inlined(function.py_func, contracts, args)
        if named and function is not zip:
            raise UntraceableError(f"{function} with named arguments")
        if function is range:
            if not all(isinstance(self.kind_of(each), types.Integer) for each in args):
                raise UntraceableError("a range whose bounds are no integers")
            return Value(None, None, Range(args))
        if function is isinstance:
            classes = args[1].constant
            if is_tuple(args[1].kind):
                classes = tuple(each.constant for each in self.items(args[1]))
            if args[0].known:
                return constant(isinstance(args[0].constant, classes))
            return constant(issubclass(python_class(self.kind_of(args[0])), classes))
        if function is len and is_tuple(args[0].kind):
            return constant(len(self.items(args[0])))
        if function is len and isinstance(args[0].kind, types.Array) and not args[0].known:
            return self.shape(args[0])[0]
        if function in _FOLDED and all(each.known for each in args):
            return constant(function(*(each.constant for each in args)))
        if function in (zip, enumerate):
            lists = [self.items(each) for each in args]
            if function is enumerate:
                lists.insert(0, [constant(i) for i in range(len(lists[0]))])
            strict = "strict" in named and bool(named["strict"].constant)
            return tuple_of([tuple_of(row) for row in zip(*lists, strict=strict)])
        if function in (min, max):
            values = self.items(args[0]) if len(args) == 1 else args
            return reduce(lambda one, other: self._chosen_or_known(function, [one, other]), values)
        return self._chosen_or_known(function, args)

    def _chosen_or_known(self, function: Any, args: Sequence[Value]) -> Value:
        """Result of a function by an implementation chosen by types, else of one Numba knows."""
        found = choosers(function, self.typing)
        if not found and isinstance(function, FunctionType) and not is_known(function, self.typing):
            return self.inlined(function, self.builder.contracts, args)
        if not found:
            return self.call(function, args)
        kinds = tuple(map(self._seen, args))
        key = function, kinds
        if key not in self._chosen:
            made = [(each._overload_func(*kinds), each._jit_options) for each in found]
            made = [each for each in made if each[0] is not None]
            self._chosen[key] = made[0] if made else None
        chosen = self._chosen[key]
        if chosen is not None:
            return self.inlined(chosen[0], bool(chosen[1].get("fastmath")), args)
        if isinstance(function, FunctionType):
            raise UntraceableError(f"{function.__qualname__} is not for {kinds}")
        return self.call(function, args)

    def _seen(self, value: Value) -> NumbaObject:
        """Type that functions are chosen by; one of all objects that Numba has no type for."""
        with suppress(ValueError):
            return self.kind_of(value)
        return types.pyobject

    def inlined(self, function: FunctionType, contracts: bool, args: Sequence[Value]) -> Value:
        """Result of a function, whose instructions are emitted here."""
        node = source_of(function)
        missing = len(node.args.args) - len(args)
        defaults = function.__defaults__ or ()
        if not 0 <= missing <= len(defaults):
            raise UntraceableError(f"{function.__qualname__} is given {len(args)} arguments")
        given = [*args, *(constant(each) for each in defaults[len(defaults) - missing :])]
        frame = Frame(function, node, given)
        before, self.builder.contracts = self.builder.contracts, contracts
        if len(self._frames) > _DEEPEST:
            raise UntraceableError("a recursion without an end")
        self._frames.append(frame)
        body: Any = node.body
        if isinstance(node, ast.Lambda):
            body = [ast.copy_location(ast.Return(body), body)]
        found = self._body(body, frame)
        self._frames.pop()
        self.builder.contracts = before
        return self.released(found, frame)

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


def in_order(
    name: str, names: Sequence[str], defaults: dict, args: Sequence[Value], named: dict
) -> list[Value]:
    """Arguments in a function's order, by place, by name and by default."""
    given = {**dict(zip(names, args, strict=False)), **named}
    rest = {each: constant(value) for each, value in defaults.items() if each not in given}
    if len(given) != len(args) + len(named) or {*given, *rest} != {*names}:
        raise UntraceableError(f"{name} takes {', '.join(names)}")
    return [{**rest, **given}[each] for each in names]


def is_method(function: Any) -> bool:
    """Whether a function is one of an object, and not of a module as Python's own are."""
    return not isinstance(getattr(function, "__self__", sys), ModuleType)


def is_traced(function: NumbaObject) -> bool:
    """Whether a compiled function is a kernel, or one of the package's that is inlined."""
    is_kernel = hasattr(function._compiler.pipeline_class, "traces")
    return is_kernel and not function.targetoptions.get("_nrt")


def python_class(kind: NumbaObject) -> type:
    """Class of Python's values of a Numba type: of numbers, arrays and tuples."""
    known: Any = (
        (types.Boolean, bool), (types.Integer, int), (types.Float, float), (types.Complex, complex),
        (types.Array, ndarray), (types.BaseTuple, tuple),
    )  # fmt: skip
    found = next((own for numba, own in known if isinstance(kind, numba)), NoneType)
    return getattr(kind, "instance_class", found)


@cache
def is_known(function: Any, typing: NumbaObject) -> bool:
    """Whether Numba knows a function of Python."""
    try:
        return typing.resolve_value_type(function) is not None
    except ValueError:
        return False


@cache
def choosers(stub: Any, typing: NumbaObject) -> tuple[NumbaObject, ...]:
    """What chooses implementations of a function for kernels by types; () for other functions."""
    is_function = isinstance(stub, FunctionType | BuiltinFunctionType)
    if not is_function or not is_known(stub, typing):
        return ()
    found = getattr(typing.resolve_value_type(stub), "templates", ())
    return tuple(each for each in found if "pipeline_class" in getattr(each, "_jit_options", ()))
