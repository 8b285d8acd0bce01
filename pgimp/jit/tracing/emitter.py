"""LLVM's instructions for the values of a kernel, by what Numba knows of types and operations."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from llvmlite import ir
from numba.core import types

from pgimp.jit.outside import NumbaObject
from pgimp.jit.results import is_tuple
from pgimp.jit.tracing.values import NONE, NOT_CONSTANT, UntraceableError, Value, constant, running

_CONTRACTED = frozenset(("fadd", "fsub", "fmul", "fdiv", "frem", "fcmp"))

#: Values that meet, each with the block that it comes from; None where a name has none.
Meeting = Sequence[tuple[Value | None, Any]]


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
    widened
        Types of variables that their first value does not tell.
    """

    def __init__(
        self, typing: NumbaObject, context: NumbaObject, module: ir.Module, widened: dict
    ) -> None:
        self.typing, self.context, self.module = typing, context, module
        self.builder = Builder()
        self.widened: dict[tuple, NumbaObject] = widened

    # Values.

    def kind_of(self, value: Value, literal: bool = False) -> NumbaObject:
        """Numba type of a value; of a constant its literal type, if it is asked for."""
        if literal and value.known and isinstance(value.constant, int | str):
            is_number = isinstance(value.constant, int) and not isinstance(value.constant, bool)
            return types.literal(int(value.constant) if is_number else value.constant)  # of an enum
        if value.kind is None:
            if isinstance(value.constant, str):
                return types.unicode_type
            value.kind = self.typing.resolve_value_type(value.constant)
        return value.kind

    def typed(self, value: Value) -> Value:
        """The value, whose type is known if Numba has one for it."""
        with suppress(ValueError):
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
        if found is None or isinstance(found, types.Optional):
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


def _same(one: Value, other: Value) -> bool:
    """Whether two values are one, or equal constants."""
    if one is other:
        return True
    a, b = one.constant, other.constant
    if a is NOT_CONSTANT or b is NOT_CONSTANT or type(a) is not type(b):
        return False
    return a is b or (isinstance(a, bool | int | float | str) and repr(a) == repr(b))
