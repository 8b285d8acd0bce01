"""Functions of a kernel's own, and the arrays that functions make."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from types import FunctionType
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from pgimp.jit.outside import NumbaObject
from pgimp.jit.results import is_tuple
from pgimp.jit.tracing.emitter import Builder
from pgimp.jit.tracing.entry import flat
from pgimp.jit.tracing.expressions import Expressions
from pgimp.jit.tracing.frame import Frame
from pgimp.jit.tracing.values import Argument, UntraceableError, Value, constant, running


class Functions(Expressions):
    """Definitions of functions, and the ends of their arrays."""

    def __init__(
        self, typing: NumbaObject, context: NumbaObject, module: ir.Module, widened: dict
    ) -> None:
        super().__init__(typing, context, module, widened)
        self._frames: list[Frame] = []
        # Functions of their own by types of arguments, and the types of their results.
        # For each of their arguments, number by number, array by array, whether it is passed.
        self._functions: dict[tuple, tuple[ir.Function, NumbaObject, list[bool]]] = {}
        self._begun: set[tuple] = set()  # those being defined

    def inlined(self, function: FunctionType, contracts: bool, args: Sequence[Value]) -> Value:
        """Result of a function, whose instructions are emitted here."""
        raise NotImplementedError

    def define(
        self,
        entry: ir.Function,
        function: FunctionType,
        contracts: bool,
        args: Sequence[Value],
        whole: bool = False,
    ) -> tuple[Value, list[Argument]]:
        """Emit a function for arguments like the given ones.

        Returns
        -------
        value
            Its result.
        arguments : list of Argument
            Its numbers and arrays, one by one. The function is given those that it uses, unless
            `whole`.
        """
        outer, self.builder = self.builder, Builder(entry.append_basic_block("entry"))
        frames, self._frames = self._frames, []
        convention, builder = self.context.call_conv, self.builder
        given = iter(convention.get_arguments(entry))
        first, start = builder.block, builder.append_basic_block("start")
        arguments: list[Argument] = []

        def argument(kind: NumbaObject) -> Value:
            if is_tuple(kind):
                return running(kind, [*map(argument, kind)])
            if isinstance(kind, types.Omitted):
                return constant(kind.value)
            if kind == types.pyobject:
                raise UntraceableError("an object in a tuple is given to a function of its own")
            arguments.append(self._argument(kind, given, first))
            return arguments[-1]

        own = [each if is_object(each) else argument(each.kind) for each in args]
        builder.position_at_end(start)
        value = self.inlined(function, contracts, own)
        result = self.kind_of(value)
        content = self.context.get_return_value(builder, result, self.content(value))
        # Its type is known only now: so is the type of the first argument, where it goes.
        entry.args[0].type = convention.get_return_type(result)
        if not whole:
            entry.args = (
                *entry.args[:2],
                *(x for each in arguments if each.used for x in each.parts),
            )
        entry.ftype.args = tuple(each.type for each in entry.args)
        convention.return_value(builder, content)
        builder.position_at_end(first)
        builder.branch(start)
        self.builder, self._frames = outer, frames
        return value, arguments

    def _argument(self, kind: NumbaObject, given: Iterator, block: Any) -> Argument:
        """A number or an array, whose parts come one by one; it is made at the end of a block."""
        parts: list[Any] = []

        def nested(form: Any) -> Any:
            if isinstance(form, tuple):
                return tuple(map(nested, form))
            parts.append(next(given))
            return parts[-1]

        model = self.context.data_model_manager[kind]
        form = nested(model.get_argument_type())

        def made() -> Any:
            if isinstance(kind, types.Boolean):  # Numba's way has branches
                return Builder(block).icmp_unsigned("!=", form, ir.Constant(form.type, 0))
            return model.from_argument(Builder(block), form)

        return Argument(kind, parts, made)

    def outlined(self, function: NumbaObject, contracts: bool, args: Sequence[Value]) -> Value:
        """Result of a function of its own, which LLVM inlines where that is worth it."""
        objects = tuple(each.constant if is_object(each) else None for each in args)
        if not all(isinstance(each, Hashable) for each in objects):  # a range, an array's constant
            return self.inlined(function.py_func, contracts, args)
        convention, passed = self.context.call_conv, [x for x in args if not is_object(x)]
        kinds = tuple(map(self.kind_of, passed))
        key = function, kinds, objects, tuple(map(type, objects))
        if key in self._begun:
            raise UntraceableError(f"{function.__qualname__} calls itself with the same types")
        if key not in self._functions:
            form = convention.get_function_type(types.none, kinds)
            name = self.module.get_unique_name(function.py_func.__qualname__)
            entry = ir.Function(self.module, form, name)
            entry.linkage = "internal"
            if hasattr(function.py_func, "is_separate"):
                entry.attributes.add("noinline")
            convention.decorate_function(entry, [f"{i}" for i in range(len(kinds))], kinds)
            self._begun.add(key)
            value, arguments = self.define(entry, function.py_func, contracts, args)
            self._begun.remove(key)
            needed = [each.used for each in arguments]
            self._functions[key] = entry, self.kind_of(value), needed
        entry, result, needed = self._functions[key]
        builder, leaves = self.builder, [leaf for each in passed for leaf in self._leaves(each)]
        used = zip(leaves, needed, strict=True)
        parts = [part for leaf, is_used in used if is_used for part in self._parts(leaf)]
        place = cgutils.alloca_once(builder, entry.args[0].type.pointee)
        error = cgutils.alloca_once(builder, entry.args[1].type.pointee)
        code = builder.call(entry, [place, error, *parts])
        status = convention._get_return_status(builder, code, builder.load(error))
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        content = self.context.get_returned_value(builder, result, builder.load(place))
        return self.owned(self.value(result, content), False)

    def _leaves(self, value: Value) -> Iterator[Value]:
        """Numbers and arrays in an argument."""
        if is_tuple(value.kind):
            for each in self.items(value):
                yield from self._leaves(each)
        else:
            yield value

    def _parts(self, value: Value) -> Iterator:
        """What is passed of a number or an array."""
        if isinstance(value, Argument):  # as it came
            value.used = True
            yield from value.parts
            return
        model = self.context.data_model_manager[self.kind_of(value)]
        yield from flat(model.as_argument(self.builder, self.content(value)))

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

    def released(self, result: Value, frame: Frame) -> Value:
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


def is_object(value: Value) -> bool:
    """Whether a value is an object that kernels do not have: a function, a class, a text."""
    return value.known and not isinstance(value.constant, bool | int | float | None)


def arrays_of(value: Value) -> list[Value]:
    """Arrays in a value."""
    if is_tuple(value.kind):
        return [array for each in value.content for array in arrays_of(each)]
    return [value] if isinstance(value.kind, types.Array) and not value.known else []
