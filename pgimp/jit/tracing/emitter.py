"""LLVM's instructions for the values of a kernel, by what Numba knows of types and operations."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from pgimp.jit.outside import NumbaObject
from pgimp.jit.tracing.values import (
    NONE,
    NOT_CONSTANT,
    Cell,
    UntraceableError,
    Value,
    constant,
    is_tuple,
    running,
)

_CONTRACTED = frozenset(("fadd", "fsub", "fmul", "fdiv", "frem", "fcmp"))

#: Values that meet, each with the block that it comes from; None where a name has none.
Meeting = Sequence[tuple[Value | None, Any]]


class AgainError(Exception):
    """A variable has another type than its first value; the walk begins anew and knows it."""


class Builder(ir.IRBuilder):
    """LLVM's builder, whose instructions may be contracted as in the function being inlined."""

    contracts = True

    def _insert(self, instruction: Any) -> Any:
        if self.contracts:
            name = getattr(instruction, "opname", None)
            if name in _CONTRACTED:
                if not instruction.flags:
                    instruction.flags.append("contract")
            elif name == "call" and isinstance(instruction.type, ir.DoubleType | ir.FloatType):
                instruction.fastmath.add("contract")
        return super()._insert(instruction)


class Emitter:
    """Emits a kernel's instructions.

    Attributes
    ----------
    typing, context
        Numba's contexts: types of operations, and their instructions.
    module : llvmlite.ir.Module
        The kernel's functions.
    builder : Builder
        Where instructions go.
    widened : dict
        Types of variables that their first value does not tell.
    """

    def __init__(
        self, typing: NumbaObject, context: NumbaObject, module: ir.Module, widened: dict
    ) -> None:
        self.typing, self.context, self.module = typing, context, module
        self.builder = Builder()
        self.widened: dict[tuple, NumbaObject] = widened
        self._resolved: dict[tuple, tuple] = {}

    # Values.

    def kind_of(self, value: Value, literal: bool = False) -> NumbaObject:
        """Numba type of a value; of a constant its literal type, if it is asked for."""
        if literal and value.known and isinstance(value.constant, int | str):
            return types.literal(value.constant)
        if value.kind is None:
            if isinstance(value.constant, str):
                return types.unicode_type
            value.kind = self.typing.resolve_value_type(value.constant)
        return value.kind

    def typed(self, value: Value) -> Value:
        """The value, whose type is known."""
        self.kind_of(value)
        return value

    def content(self, value: Value) -> Any:
        """LLVM value of a value."""
        if isinstance(value.content, list):
            items = [self.content(each) for each in value.content]
            return self.context.make_tuple(self.builder, value.kind, items)
        if not value.known:
            return value.content
        if value.kind == types.none:
            return self.context.get_dummy_value()
        if isinstance(value.constant, bool | int | float):
            return self.context.get_constant(value.kind, value.constant)
        return self.context.get_constant_generic(self.builder, self.kind_of(value), value.constant)

    def value(self, kind: NumbaObject, content: Any) -> Value:
        """Value of an LLVM value; tuples are taken apart."""
        if is_tuple(kind):
            extract = self.builder.extract_value
            return running(kind, [self.value(k, extract(content, i)) for i, k in enumerate(kind)])
        if kind in (types.none, types.void):
            return NONE
        return running(types.unliteral(kind), content)

    def items(self, value: Value) -> list[Value]:
        """Items of a tuple."""
        if not isinstance(value.content, list):
            raise UntraceableError(f"{value.kind or value.constant} has no known items")
        return value.content

    # Types that meet.

    def unified(self, one: NumbaObject, other: NumbaObject) -> NumbaObject:
        """Type of what may have either of two types."""
        if one == other:
            return one
        if is_tuple(one) and is_tuple(other) and len(one) == len(other):
            kinds = [self.unified(*both) for both in zip(one, other, strict=True)]
            return types.BaseTuple.from_types(kinds, getattr(one, "instance_class", None))
        found = self.typing.unify_types(one, other)
        if found is None:
            raise UntraceableError(f"a value would be {one} or {other}")
        return found

    def cast(self, value: Value, kind: NumbaObject) -> Value:
        """The value as one of another type."""
        if value.kind == kind:
            return value
        if is_tuple(kind):
            items = zip(self.items(value), kind, strict=True)
            return running(kind, [self.cast(*each) for each in items])
        if value.known and isinstance(value.constant, int) and kind == types.float64:
            return constant(float(value.constant))
        here = self.kind_of(value)
        return running(kind, self.context.cast(self.builder, self.content(value), here, kind))

    def met(self, meeting: Meeting) -> Value:
        """Value where several meet, at the beginning of the present block."""
        present = [value for value, _ in meeting if value is not None]
        first = present[0]
        if len(present) == len(meeting) and all(_same(value, first) for value in present):
            return first
        kind = self.kind_of(first)
        for value in present[1:]:
            kind = self.unified(kind, self.kind_of(value))
        return self.met_as(meeting, kind)

    def met_as(self, meeting: Meeting, kind: NumbaObject) -> Value:
        """As `met`, of a given type."""
        first = meeting[0][0]
        if first is not None and all(value is first for value, _ in meeting):
            return self.cast(first, kind)
        if is_tuple(kind):
            items = [(None if v is None else self.items(v), block) for v, block in meeting]
            return running(kind, [
                self.met_as([(None if v is None else v[i], block) for v, block in items], each)
                for i, each in enumerate(kind)
            ])  # fmt: skip
        if kind == types.none:
            return NONE
        here, form, incoming = self.builder.block, self.context.get_value_type(kind), []
        for value, block in meeting:
            if value is None:
                incoming.append((ir.Constant(form, ir.Undefined), block))
                continue
            self.builder.position_before(block.terminator)
            incoming.append((self.content(self.cast(value, kind)), self.builder.block))
        self.builder.position_at_start(here)
        phi = self.builder.phi(form)
        for each in incoming:
            phi.add_incoming(*each)
        self.builder.position_at_end(here)
        return running(kind, phi)

    def select(self, test: Any, one: Value, other: Value) -> Value:
        """One of two values of the same type."""
        if is_tuple(one.kind):
            pairs = zip(self.items(one), self.items(other), strict=True)
            return running(one.kind, [self.select(test, *pair) for pair in pairs])
        found = self.builder.select(test, self.content(one), self.content(other))
        return running(one.kind, found)

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
        found = self.typing.resolve_getattr(kind, name)
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

    def set_item(self, array: Value, index: Value, value: Value) -> None:
        """Set entries of an array."""
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


def _same(one: Value, other: Value) -> bool:
    """Whether two values are one, or equal constants."""
    if one is other:
        return True
    a, b = one.constant, other.constant
    if a is NOT_CONSTANT or b is NOT_CONSTANT or type(a) is not type(b):
        return False
    return a is b or (isinstance(a, bool | int | float | str) and repr(a) == repr(b))
