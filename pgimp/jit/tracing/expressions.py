"""Expressions of a kernel."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial, reduce
from typing import Any

from llvmlite import ir
from numba.core import types

from pgimp.jit.results import is_tuple
from pgimp.jit.tracing.emitter import Meeting
from pgimp.jit.tracing.frame import Frame
from pgimp.jit.tracing.operations import Operations
from pgimp.jit.tracing.values import (
    NONE,
    Cell,
    Range,
    UntraceableError,
    Value,
    constant,
    running,
    tuple_of,
)

OPERATIONS: dict[type, Callable] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
    ast.LShift: operator.lshift, ast.RShift: operator.rshift, ast.BitOr: operator.or_,
    ast.BitXor: operator.xor, ast.BitAnd: operator.and_, ast.USub: operator.neg,
    ast.UAdd: operator.pos, ast.Invert: operator.invert, ast.Eq: operator.eq,
    ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge, ast.Is: operator.is_, ast.IsNot: operator.is_not,
    ast.In: lambda one, other: one in other, ast.NotIn: lambda one, other: one not in other,
}  # fmt: skip

#: Index of an array or a tuple: a value, a slice of values, or a list of such.
Index = Any


class Expressions(Operations):
    """Values of expressions. What is known, by types or constants, is computed on the way."""

    def expression(self, node: ast.expr, frame: Frame) -> Value:
        """Value of an expression."""
        match node:
            case ast.Name():
                return self.name(node.id, frame)
            case ast.Constant():
                return constant(node.value)
            case ast.Attribute():
                return self.attribute(self.expression(node.value, frame), node.attr)
            case ast.BinOp():
                one, other = self.expression(node.left, frame), self.expression(node.right, frame)
                return self.operation(node.op, one, other)
            case ast.Subscript():
                value = self.expression(node.value, frame)
                return self.item(value, self.index(node.slice, frame))
            case ast.Call():
                return self.called(node, frame)
            case ast.Tuple():
                return tuple_of([self.typed(each) for each in self.listed(node.elts, frame)])
            case ast.Compare():
                return self._comparison(node, frame)
            case ast.UnaryOp(op=ast.Not()):
                return self.negated(self.condition(node.operand, frame))
            case ast.UnaryOp():
                value = self.expression(node.operand, frame)
                function = OPERATIONS[type(node.op)]
                if value.known:
                    return constant(function(value.constant))
                return self.call(function, [value])
            case ast.BoolOp():
                return self._chain(node, node.values, frame, self.expression)
            case ast.IfExp():
                return self._choice(node, frame)
        raise UntraceableError(f"{type(node).__name__} is not for kernels")

    def called(self, node: ast.Call, frame: Frame) -> Value:
        """Value of a call."""
        raise NotImplementedError

    def name(self, name: str, frame: Frame) -> Value:
        """Value of a name."""
        if name not in frame.names:
            return frame.outer(name)
        found = frame.names[name]
        if found is None:
            raise UntraceableError(f"{name} may be of two types")
        return self.loaded(found) if isinstance(found, Cell) else found

    def listed(self, nodes: Sequence[ast.expr], frame: Frame) -> list[Value]:
        """Values of some expressions, of starred ones their items."""
        found: list[Value] = []
        for each in nodes:
            if isinstance(each, ast.Starred):
                found += self.items(self.expression(each.value, frame))
            else:
                found.append(self.expression(each, frame))
        return found

    def operation(self, node: ast.operator, one: Value, other: Value) -> Value:
        """Result of an operation."""
        function = OPERATIONS[type(node)]
        if one.known and other.known:
            with suppress(ZeroDivisionError):  # as a kernel has it: behind a branch not taken
                return constant(function(one.constant, other.constant))
        if is_tuple(one.kind) and is_tuple(other.kind) and function is operator.add:
            return tuple_of(self.items(one) + self.items(other))
        if is_tuple(one.kind) and other.known and function is operator.mul:
            return tuple_of(self.items(one) * other.constant)
        return self.call(function, [one, other])

    # Conditions.

    def condition(self, node: ast.expr, frame: Frame) -> Value:
        """Truth of an expression."""
        if isinstance(node, ast.BoolOp):
            return self._chain(node, node.values, frame, self.condition)
        return self.truth(self.expression(node, frame))

    def truth(self, value: Value) -> Value:
        """Truth of a value."""
        if is_tuple(value.kind):
            return constant(bool(self.items(value)))
        if value.known:
            return constant(bool(value.constant))
        if value.kind == types.boolean:
            return value
        try:
            truth = self.context.is_true(self.builder, value.kind, self.content(value))
        except NotImplementedError as error:
            raise UntraceableError(f"{value.kind} is neither true nor false") from error
        return running(types.boolean, truth)

    def negated(self, value: Value) -> Value:
        """The opposite of a truth."""
        if value.known:
            return constant(not value.constant)
        return running(types.boolean, self.builder.not_(self.content(value)))

    def _chain(
        self, node: ast.BoolOp, nodes: Sequence[ast.expr], frame: Frame, take: Callable
    ) -> Value:
        """The first value of a chain that ends it, as the first true one ends one of ``or``."""
        first, ends = take(nodes[0], frame), isinstance(node.op, ast.Or)
        if len(nodes) == 1:
            return first
        truth = self.truth(first)
        if truth.known:
            return first if truth.constant == ends else self._chain(node, nodes[1:], frame, take)
        builder = self.builder
        more, after, block = self.new_block(), self.new_block(), builder.block
        builder.cbranch(self.content(truth), *((after, more) if ends else (more, after)))
        builder.position_at_end(more)
        rest = self._chain(node, nodes[1:], frame, take)
        end = builder.block
        builder.branch(after)
        builder.position_at_end(after)
        return self.met([(constant(ends) if first is truth else first, block), (rest, end)])

    def _comparison(self, node: ast.Compare, frame: Frame) -> Value:
        left, found = self.expression(node.left, frame), constant(True)
        for sign, each in zip(node.ops, node.comparators, strict=True):
            right = self.expression(each, frame)
            this = self._compared(sign, left, right)
            if not found.known and not this.known:
                this = self.call(operator.and_, [found, this])
            elif (found.known and not found.constant) or (this.known and this.constant):
                this = found
            left, found = right, this
        return found

    def _compared(self, sign: ast.cmpop, left: Value, right: Value) -> Value:
        function = OPERATIONS[type(sign)]
        if left.known and right.known:
            return constant(function(left.constant, right.constant))
        if isinstance(sign, ast.In | ast.NotIn) and is_tuple(right.kind):
            same = [self._compared(ast.Eq(), left, each) for each in self.items(right)]
            if any(each.known and each.constant for each in same):
                found = constant(True)
            else:
                unknown = [each for each in same if not each.known] or [constant(False)]
                found = reduce(partial(self.operation, ast.BitOr()), unknown)
            return found if isinstance(sign, ast.In) else self.negated(found)
        return self.call(function, [left, right])

    def _choice(self, node: ast.IfExp, frame: Frame) -> Value:
        test = self.condition(node.test, frame)
        if test.known:
            return self.expression(node.body if test.constant else node.orelse, frame)
        builder, meeting = self.builder, []
        blocks, after = (self.new_block(), self.new_block()), self.new_block()
        builder.cbranch(self.content(test), *blocks)
        for block, each in zip(blocks, (node.body, node.orelse), strict=True):
            builder.position_at_end(block)
            value = self.expression(each, frame)
            meeting.append((value, builder.block))
            builder.branch(after)
        builder.position_at_end(after)
        if all(isinstance(value.constant, Range) for value, _ in meeting):
            return self._range(meeting)
        return self.met(meeting)

    def _range(self, meeting: Meeting) -> Value:
        """Range that is one of several."""
        bounds = [
            self.met([(value.constant.bounds[i], block) for value, block in meeting if value])
            for i in range(3)
        ]
        return Value(None, None, Range(bounds))

    def new_block(self) -> Any:
        """A block of instructions, still empty."""
        return self.builder.append_basic_block()

    # Items.

    def index(self, node: ast.expr, frame: Frame) -> Index:
        """Index of an item or of a part."""
        match node:
            case ast.Slice():
                parts = node.lower, node.upper, node.step
                return slice(*(each and self.expression(each, frame) for each in parts))
            case ast.Tuple():
                return [self.index(each, frame) for each in node.elts]
        return self.expression(node, frame)

    def index_value(self, index: Index) -> Value:
        """An index as a value."""
        match index:
            case slice():
                parts = [index.start, index.stop] + [index.step] * (index.step is not None)
                return self.call(slice, [NONE if each is None else each for each in parts])
            case list():
                return tuple_of([self.index_value(each) for each in index])
        return index

    def item(self, value: Value, index: Index) -> Value:
        """Item or part of a tuple or an array."""
        if value.known and isinstance(index, Value) and index.known:
            return constant(value.constant[index.constant])
        if isinstance(value.kind, types.Array) and isinstance(index, Value | list):
            address = self.element(value, self.index_value(index))
            if address is not None:
                kind = value.kind.dtype
                return running(kind, self.context.unpack_value(self.builder, kind, address))
        if not is_tuple(value.kind):
            return self.call(operator.getitem, [value, self.index_value(index)])
        items = self.items(value)
        if isinstance(index, slice):
            bounds = (index.start, index.stop, index.step)
            if not all(each is None or each.known for each in bounds):
                raise UntraceableError("a part of a tuple whose length only the run knows")
            return tuple_of(items[slice(*(each and each.constant for each in bounds))])
        if index.known:
            # It is beyond the end only behind a condition that is false when the kernel runs.
            return items[index.constant if -len(items) <= index.constant < len(items) else -1]
        return self._any_item(items, index)

    def _any_item(self, items: list[Value], index: Value) -> Value:
        """Item of a tuple by a number that is known only when the kernel runs."""
        if not isinstance(index.kind, types.Integer | types.Boolean):
            raise UntraceableError(f"{index.kind} as the index of a tuple")
        kind = items[0].kind
        for each in items[1:]:
            kind = self.unified(kind, each.kind)
        at, found = self.content(self.cast(index, types.intp)), self.cast(items[-1], kind)
        below = self.builder.icmp_signed("<", at, ir.Constant(at.type, 0))  # from the end
        at = self.builder.select(below, self.builder.add(at, ir.Constant(at.type, len(items))), at)
        for number, each in reversed([*enumerate(items[:-1])]):
            here = self.builder.icmp_signed("==", at, ir.Constant(at.type, number))
            found = self.select(here, self.cast(each, kind), found)
        return found
