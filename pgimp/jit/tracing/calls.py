"""Calls in a kernel: functions of the package are inlined, others left to Numba."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from functools import cache, reduce
from types import BuiltinFunctionType, FunctionType
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.dispatcher import Dispatcher

from pgimp.jit.outside import NumbaObject
from pgimp.jit.tracing.emitter import Builder
from pgimp.jit.tracing.expressions import Expressions
from pgimp.jit.tracing.frame import Frame
from pgimp.jit.tracing.source import source_of
from pgimp.jit.tracing.values import (
    NONE,
    Range,
    UntraceableError,
    Value,
    constant,
    is_tuple,
    running,
    tuple_of,
)

#: Functions in functions up to this depth; a recursion ends before, when types are at their end.
_DEEPEST = 200

#: Functions whose results are computed where all their arguments are constants.
_FOLDED = (min, max, abs, int, float, bool)


class Calls(Expressions):
    """Calls of functions."""

    def __init__(
        self, typing: NumbaObject, context: NumbaObject, module: ir.Module, widened: dict
    ) -> None:
        super().__init__(typing, context, module, widened)
        self._frames: list[Frame] = []
        # Functions of their own by types of arguments, and the types of their results.
        self._functions: dict[tuple, tuple[ir.Function, NumbaObject]] = {}
        # Implementations by types of arguments, and their options.
        self._chosen: dict[tuple, tuple[FunctionType, dict] | None] = {}

    def called(self, node: ast.Call, frame: Frame) -> Value:
        """Value of a call."""
        if isinstance(node.func, ast.Name) and node.args:
            if node.func.id in ("tuple", "sum") and isinstance(node.args[0], ast.GeneratorExp):
                items = [self.typed(each) for each in self._generated(node.args[0], frame)]
                if node.func.id == "tuple":
                    return tuple_of(items)
                return reduce(lambda one, other: self.operation(ast.Add(), one, other), items)
        if isinstance(node.func, ast.Attribute):
            array = self.expression(node.func.value, frame)
            if isinstance(array.kind, types.Array) and not array.known:
                return self.call(node.func.attr, self.listed(node.args, frame), array)
        callee, args = self.expression(node.func, frame), self.listed(node.args, frame)
        named = {each.arg: self.expression(each.value, frame) for each in node.keywords}
        if not callee.known:
            raise UntraceableError("a call of what is known only when the kernel runs")
        return self._result(callee.constant, args, named)

    def _generated(self, node: ast.GeneratorExp, frame: Frame) -> list[Value]:
        """Values of an expression for each item of a tuple, or each number of a known range."""
        (loop,), found, before = node.generators, [], (dict(frame.names), frame.cells)
        frame.cells = {}  # its names are its own
        over = self.expression(loop.iter, frame)
        if isinstance(over.constant, Range):
            items = [constant(i) for i in range(*(each.constant for each in over.constant.bounds))]
        else:
            items = self.items(over)
        for item in items:
            self.assign(loop.target, item, frame)
            if all(self.condition(each, frame).constant for each in loop.ifs):
                found.append(self.expression(node.elt, frame))
        frame.names, frame.cells = before
        return found

    def assign(self, target: ast.expr, value: Value, frame: Frame) -> None:
        """Give a value to names, or to what is in an array or a record."""
        raise NotImplementedError

    def _result(self, function: Any, args: list[Value], named: dict[str | None, Value]) -> Value:
        fields = getattr(function, "_fields", None)
        if fields is not None:
            given = {**dict(zip(fields, args, strict=False)), **named}
            rest = {name: constant(value) for name, value in function._field_defaults.items()}
            items = [self.typed({**rest, **given}[name]) for name in fields]
            return tuple_of(items, function)
        if isinstance(function, FunctionType):
            names = function.__code__.co_varnames[: function.__code__.co_argcount]
            args = [*args, *(named.pop(each) for each in names[len(args) :] if each in named)]
            if hasattr(function, "of_types"):
                return constant(function(*map(self.kind_of, args)))
        if isinstance(function, Dispatcher) and is_traced(function):
            contracts = "contract" in (function.targetoptions.get("fastmath") or ())
            if function.targetoptions.get("no_cpython_wrapper"):
                return self._outlined(function, contracts, args)
            return self.inlined(function.py_func, contracts, args)
        if named and function is not zip:
            raise UntraceableError(f"{function} with named arguments")
        if function is range:
            return Value(None, None, Range(args))
        if function is len and is_tuple(args[0].kind):
            return constant(len(self.items(args[0])))
        if function in _FOLDED and all(each.known for each in args):
            return constant(function(*(each.constant for each in args)))
        if function in (zip, enumerate):
            lists = [self.items(each) for each in args]
            if function is enumerate:
                lists.insert(0, [constant(i) for i in range(len(lists[0]))])
            return tuple_of([tuple_of(row) for row in zip(*lists, strict=True)])
        if function in (min, max):
            values = self.items(args[0]) if len(args) == 1 else args
            return reduce(lambda one, other: self._chosen_or_known(function, [one, other]), values)
        return self._chosen_or_known(function, args)

    def _chosen_or_known(self, function: Any, args: Sequence[Value]) -> Value:
        """Result of a function by an implementation chosen by types, else of one Numba knows."""
        found = choosers(function, self.typing)
        if not found:
            return self.call(function, args)
        literal = any(each.prefer_literal for each in found)
        kinds = tuple(self.kind_of(each, literal) for each in args)
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

    def define(
        self, entry: ir.Function, function: FunctionType, contracts: bool, args: Sequence[Value]
    ) -> NumbaObject:
        """Emit a function for arguments like the given ones; return the type of its result."""
        outer, self.builder = self.builder, Builder(entry.append_basic_block("entry"))
        frames, self._frames = self._frames, []
        convention, builder = self.context.call_conv, self.builder
        given = iter(convention.get_arguments(entry))
        own = [each if is_object(each) else self._argument(each.kind, given) for each in args]
        first, start = builder.block, builder.append_basic_block("start")
        builder.position_at_end(start)
        value = self.inlined(function, contracts, own)
        result = self.kind_of(value)
        content = self.context.get_return_value(builder, result, self.content(value))
        # Its type is known only now: so is the type of the first argument, where it goes.
        entry.args[0].type = convention.get_return_type(result)
        entry.ftype.args = entry.args[0].type, *entry.ftype.args[1:]
        convention.return_value(builder, content)
        builder.position_at_end(first)
        builder.branch(start)
        self.builder, self._frames = outer, frames
        return result

    def _argument(self, kind: NumbaObject, given: Iterator) -> Value:
        """Value of an argument, whose numbers and arrays come one by one."""
        if is_tuple(kind):
            return running(kind, [self._argument(each, given) for each in kind])

        def nested(form: Any) -> Any:
            return tuple(map(nested, form)) if isinstance(form, tuple) else next(given)

        model = self.context.data_model_manager[kind]
        return running(kind, model.from_argument(self.builder, nested(model.get_argument_type())))

    def _outlined(self, function: NumbaObject, contracts: bool, args: Sequence[Value]) -> Value:
        """Result of a function of its own, which LLVM inlines where that is worth it."""
        convention, passed = self.context.call_conv, [x for x in args if not is_object(x)]
        kinds = tuple(map(self.kind_of, passed))
        key = function, kinds, *(each.constant for each in args if is_object(each))
        if key not in self._functions:
            form = convention.get_function_type(types.none, kinds)
            name = f"{function.py_func.__qualname__}.{len(self._functions)}"
            entry = ir.Function(self.module, form, name)
            entry.linkage = "internal"
            convention.decorate_function(entry, [f"{i}" for i in range(len(kinds))], kinds)
            result = self.define(entry, function.py_func, contracts, args)
            self._functions[key] = entry, result
        entry, result = self._functions[key]
        builder, parts = self.builder, [part for each in passed for part in self._parts(each)]
        place = cgutils.alloca_once(builder, entry.args[0].type.pointee)
        error = cgutils.alloca_once(builder, entry.args[1].type.pointee)
        code = builder.call(entry, [place, error, *parts])
        status = convention._get_return_status(builder, code, builder.load(error))
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        content = self.context.get_returned_value(builder, result, builder.load(place))
        return self.owned(self.value(result, content), False)

    def _parts(self, value: Value) -> Iterator:
        """What is passed of an argument: its numbers, and what arrays consist of."""
        if isinstance(value.content, list):
            for each in value.content:
                yield from self._parts(each)
            return
        model = self.context.data_model_manager[self.kind_of(value)]
        yield from _flat(model.as_argument(self.builder, self.content(value)))

    def inlined(self, function: FunctionType, contracts: bool, args: Sequence[Value]) -> Value:
        """Result of a function, whose instructions are emitted here."""
        node = source_of(function)
        missing = len(node.args.args) - len(args)
        defaults = function.__defaults__ or ()
        given = [*args, *(constant(each) for each in defaults[len(defaults) - missing :])]
        frame = Frame(function, node, given)
        before, self.builder.contracts = self.builder.contracts, contracts
        if len(self._frames) > _DEEPEST:
            raise UntraceableError("a recursion without an end")
        self._frames.append(frame)
        if isinstance(node, ast.Lambda):
            found = self.expression(node.body, frame)
        else:
            found = self._body(node.body, frame)
        self._frames.pop()
        self.builder.contracts = before
        return self._released(found, frame)

    def _body(self, body: list[ast.stmt], frame: Frame) -> Value:
        found = self.block(body, frame)
        if found is not None:
            return found
        if not self.builder.block.is_terminated:
            self.leave(NONE, frame)
        self.builder.position_at_end(frame.exit)
        return self.met(frame.returned)

    def owned(self, value: Value, is_part: bool) -> Value:
        """A new value; arrays in it are released at the end of the present function.

        Parts of arrays live as long as these, and are released at once.

        Raises
        ------
        UntraceableError
            If an array is made in a loop: the one before would be lost.
        """
        count = self.context.nrt
        for each in arrays_of(value) if self.context.enable_nrt else ():
            if is_part:
                count.decref(self.builder, each.kind, each.content)
                continue
            if not self._frames:
                continue
            if self._frames[-1].loops:
                raise UntraceableError("an array is made in a loop")
            form = self.context.get_value_type(each.kind)
            address = cgutils.alloca_once(self.builder, form, zfill=True)
            self.builder.store(each.content, address)
            self._frames[-1].owned.append((each.kind, address))
        return value

    def _released(self, result: Value, frame: Frame) -> Value:
        """The result of a function, whose other arrays are released."""
        if not self.context.enable_nrt:
            return result
        builder, count = self.builder, self.context.nrt
        if frame.owned or not self._frames:
            for each in arrays_of(result):
                count.incref(builder, each.kind, each.content)
        for kind, address in frame.owned:
            count.decref(builder, kind, builder.load(address))
            builder.store(cgutils.get_null_value(address.type.pointee), address)
        return self.owned(result, False) if frame.owned else result

    def leave(self, value: Value, frame: Frame) -> None:
        """Jump to the end of the function with its result."""
        if frame.exit is None:
            frame.exit = self.new_block()
        frame.returned.append((value, self.builder.block))
        self.builder.branch(frame.exit)

    def block(self, body: Sequence[ast.stmt], frame: Frame) -> Value | None:
        """Emit statements; return the function's result if it is known at their end."""
        raise NotImplementedError


def is_object(value: Value) -> bool:
    """Whether a value is an object that kernels do not have: a function, a class, a text."""
    return value.known and not isinstance(value.constant, bool | int | float | None)


def _flat(parts: Any) -> Iterator:
    """Parts of nested tuples, one by one."""
    if isinstance(parts, tuple | list):
        for each in parts:
            yield from _flat(each)
    else:
        yield parts


def arrays_of(value: Value) -> list[Value]:
    """Arrays in a value."""
    if isinstance(value.content, list):
        return [array for each in value.content for array in arrays_of(each)]
    return [value] if isinstance(value.kind, types.Array) and not value.known else []


def is_traced(function: NumbaObject) -> bool:
    """Whether a compiled function is a kernel, or one of the package's that is inlined."""
    is_kernel = hasattr(function._compiler.pipeline_class, "traces")
    return is_kernel and not function.targetoptions.get("_nrt")


@cache
def choosers(stub: Any, typing: NumbaObject) -> tuple[NumbaObject, ...]:
    """What chooses implementations of a function for kernels by types; () for other functions."""
    if not isinstance(stub, FunctionType | BuiltinFunctionType):
        return ()
    found = getattr(typing.resolve_value_type(stub), "templates", ())
    return tuple(each for each in found if "pipeline_class" in getattr(each, "_jit_options", ()))
