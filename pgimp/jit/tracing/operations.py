"""Operations of a kernel: variables that loops keep, and all that Numba knows."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from pgimp.jit.memory import part_of
from pgimp.jit.outside import NumbaObject
from pgimp.jit.results import is_tuple
from pgimp.jit.tracing.emitter import Emitter
from pgimp.jit.tracing.values import NONE, Cell, UntraceableError, Value, constant, running

_INTEGER = ir.IntType(64)


class AgainError(Exception):
    """A variable has another type than its first value; the walk begins anew and knows it."""


class Operations(Emitter):
    """Emits what Numba knows of operations, by the types of their arguments."""

    def __init__(
        self, typing: NumbaObject, context: NumbaObject, module: ir.Module, widened: dict
    ) -> None:
        super().__init__(typing, context, module, widened)
        self._resolved: dict[tuple, tuple] = {}

    # Variables that change in loops.

    def cell(self, kind: NumbaObject, key: tuple) -> Cell:
        """Make a cell."""

        def address(kind: NumbaObject) -> Any:
            if is_tuple(kind):
                return [address(each) for each in kind]
            if kind == types.none:
                return None
            return cgutils.alloca_once(self.builder, self.context.get_value_type(kind))

        kind = self.widened.get(key, kind)
        return Cell(kind, address(kind), key)

    def loaded(self, cell: Cell) -> Value:
        """Present value of a cell."""

        def load(kind: NumbaObject, address: Any) -> Value:
            if is_tuple(kind):
                return running(kind, [load(*each) for each in zip(kind, address, strict=True)])
            return NONE if address is None else running(kind, self.builder.load(address))

        return load(cell.kind, cell.addresses)

    def keep(self, cell: Cell, value: Value) -> None:
        """Set a cell.

        Raises
        ------
        AgainError
            If its type is too narrow for the value.
        """

        def store(value: Value, kind: NumbaObject, address: Any) -> None:
            if is_tuple(kind):
                for each in zip(self.items(value), kind, address, strict=True):
                    store(*each)
            elif address is not None:
                self.builder.store(self.content(value), address)

        kind = self.unified(cell.kind, self.kind_of(value))
        if kind != cell.kind:
            self.widened[cell.key] = kind
            raise AgainError
        store(self.cast(value, kind), kind, cell.addresses)

    # What Numba knows.

    def call(self, function: Any, args: Sequence[Value], array: Value | None = None) -> Value:
        """Result of a function or operation that Numba knows; of a method with its array."""
        kinds = tuple(self.kind_of(each, True) for each in args)
        key = function, array and array.kind, kinds
        if key not in self._resolved:
            kind = None
            with suppress(ValueError):  # which is how Numba says that it does not know a function
                if array is None:
                    kind = self.typing.resolve_value_type(function)
                else:
                    kind = self.typing.resolve_getattr(array.kind, function)
            signature = kind and self.typing.resolve_function_type(kind, kinds, {})
            if signature is None:
                raise UntraceableError(f"{getattr(function, '__name__', function)} of {kinds}")
            self._resolved[key] = signature, self.context.get_function(kind, signature)
        signature, emit = self._resolved[key]
        wanted = signature.args
        if wanted and isinstance(wanted[-1], types.StarArgTuple | types.StarArgUniTuple):
            fixed = len(wanted) - 1
            args = [*args[:fixed], running(wanted[-1], [*args[fixed:]])]
        self.context.add_linking_libs(getattr(emit, "libs", ()))
        values = [] if array is None else [self.content(array)]
        found = emit(self.builder, values + self._as(args, wanted))
        return self.owned(self.value(signature.return_type, found), function is operator.getitem)

    def owned(self, value: Value, is_part: bool) -> Value:
        """A new value; arrays in it are released when they are not needed any more."""
        return value

    def _as(self, args: Sequence[Value], kinds: Sequence[NumbaObject]) -> list:
        """LLVM values of arguments as those of given types."""
        given = [
            self.content(value if isinstance(kind, types.Literal) else self.cast(value, kind))
            for value, kind in zip(args, kinds, strict=False)
        ]
        for kind in kinds[len(given) :]:
            if not isinstance(kind, types.Omitted):
                raise UntraceableError(f"{len(given)} arguments in place of {len(kinds)}")
            given.append(self.context.get_constant_generic(self.builder, kind, None))
        return given

    def attribute(self, value: Value, name: str) -> Value:
        """Attribute of a value."""
        if value.known and not isinstance(value.constant, bool | int | float):
            return constant(getattr(value.constant, name))
        kind: NumbaObject = self.kind_of(value)
        if hasattr(kind, "fields") and is_tuple(kind) and name in kind.fields:
            return self.items(value)[kind.fields.index(name)]
        if isinstance(kind, types.Array) and name == "shape":
            lengths = self.shape(value)
            return running(types.UniTuple(types.intp, len(lengths)), lengths)
        found = self.typing.resolve_getattr(kind, name)
        if isinstance(found, types.NestedArray) and isinstance(found.dtype, types.Number):
            return self._nested(value, name)
        if found is None:
            raise UntraceableError(f"{kind} has no attribute {name}")
        emit = self.context.get_getattr(kind, name)
        part = emit(self.context, self.builder, kind, self.content(value), name)
        return self.owned(self.value(found, part), True)

    def set_attribute(self, record: Value, name: str, value: Value) -> None:
        """Set an attribute of a record."""
        signature = self.typing.resolve_setattr(record.kind, name, self.kind_of(value))
        if signature is None:
            raise UntraceableError(f"the attribute {name} of {record.kind} cannot be set")
        emit = self.context.get_setattr(name, signature)
        emit(self.builder, self._as((record, value), signature.args))

    def element(self, array: Value, index: Value) -> Any:
        """Address of an element of a dense array by an integer for each dimension; else None.

        As Numba's, in a third of its instructions.
        """
        kind = self.kind_of(array)
        numbers = self.items(index) if is_tuple(index.kind) else [index]
        dense = isinstance(kind, types.Array) and kind.layout == "C" and kind.aligned
        if not dense or not isinstance(kind.dtype, types.Number | types.Record):
            return None
        if len(numbers) != kind.ndim or not numbers or self.context.enable_boundscheck:
            return None
        if not all(isinstance(self.kind_of(each), types.Integer) for each in numbers):
            return None
        builder, whole, offset = self.builder, self.content(array), None
        part = partial(part_of, self.context, builder, kind, whole)
        for d, each in enumerate(numbers):
            known = each.known and each.constant >= 0
            at = self.content(self.cast(each, types.intp))
            length = None
            if offset is not None or not known:
                length = part("shape", d)
            if not known and self.kind_of(each).signed:  # from the end
                below = builder.icmp_signed("<", at, ir.Constant(at.type, 0))
                at = builder.select(below, builder.add(at, length), at)
            if offset is not None:
                at = builder.add(builder.mul(offset, length), at)
            offset = at
        return builder.gep(part("data"), [offset])

    def shape(self, array: Value) -> list[Value]:
        """Lengths of an array."""
        part = partial(part_of, self.context, self.builder, array.kind, self.content(array))
        return [running(types.intp, part("shape", d)) for d in range(array.kind.ndim)]

    def _nested(self, record: Value, name: str) -> Value:
        """An array in a record; all of it but its address is constant."""
        kind, context, builder = record.kind.typeof(name), self.context, self.builder
        form = context.get_value_type(kind)
        number, offset = context.get_data_type(kind.dtype), record.kind.offset(name)
        data = cgutils.get_record_member(builder, self.content(record), offset, number)
        owner = (ir.Constant(each, None) for each in form.elements[:2])
        sizes = (ir.Constant(_INTEGER, n) for n in (kind.nitems, kind.dtype.bitwidth // 8))
        unset = ir.Constant(form.elements[4], ir.Undefined)
        rows = ir.ArrayType(_INTEGER, kind.ndim)
        layout = (ir.Constant(rows, [*each]) for each in (kind.shape, kind.strides))
        whole = ir.Constant(form, [*owner, *sizes, unset, *layout])
        return running(kind, builder.insert_value(whole, data, 4))

    def set_item(self, array: Value, index: Value, value: Value) -> None:
        """Set entries of an array."""
        address = self.element(array, index) if array.kind.mutable else None
        if address is not None:
            content = self.content(self.cast(value, array.kind.dtype))
            return self.context.pack_value(self.builder, array.kind.dtype, content, address)
        kinds = tuple(map(self.kind_of, (array, index, value)))
        key = "[]", kinds
        if key not in self._resolved:
            signature = self.typing.resolve_setitem(*kinds)
            if signature is None:
                raise UntraceableError(f"entries of {kinds[0]} cannot be set")
            function = self.context.get_function(operator.setitem, signature)
            self._resolved[key] = signature, function
        signature, emit = self._resolved[key]
        emit(self.builder, self._as((array, index, value), signature.args))
