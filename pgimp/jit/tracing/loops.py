"""Variables and loops of a kernel."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

from llvmlite import ir
from numba.core import types

from pgimp.jit.outside import NumbaObject
from pgimp.jit.results import is_tuple
from pgimp.jit.tracing.calls import Calls
from pgimp.jit.tracing.frame import Frame
from pgimp.jit.tracing.source import kept
from pgimp.jit.tracing.values import (
    Cell,
    Range,
    UntraceableError,
    Value,
    constant,
    running,
    tuple_of,
)

_INTEGER = ir.IntType(64)

#: Loops of more turns are not unrolled, even if their number is the index of a tuple.
_UNROLLED = 9


class Loops(Calls):
    """Assignments and loops."""

    def __init__(
        self, typing: NumbaObject, context: NumbaObject, module: ir.Module, widened: dict
    ) -> None:
        super().__init__(typing, context, module, widened)
        #: Blocks after loops that a ``break`` reaches.
        self._left: set[Any] = set()

    # Assignments.

    def assign(self, target: ast.expr, value: Value, frame: Frame) -> None:
        """Give a value to names, or to what is in an array or a record."""
        match target:
            case ast.Name():
                self._name(target.id, value, frame)
            case ast.Tuple() if isinstance(value.kind, types.Array):
                items = [self.item(value, constant(i)) for i in range(len(target.elts))]
                self._unpack(target.elts, items, frame)
            case ast.Tuple():
                self._unpack(target.elts, self.items(value), frame)
            case ast.Subscript():
                array = self.expression(target.value, frame)
                index = self.index_value(self.index(target.slice, frame))
                self.set_item(array, index, value)
            case ast.Attribute():
                self.set_attribute(self.expression(target.value, frame), target.attr, value)
            case _:
                raise UntraceableError(f"{type(target).__name__} cannot be set")

    def _unpack(self, targets: list[ast.expr], items: list[Value], frame: Frame) -> None:
        for i, each in enumerate(targets):
            if isinstance(each, ast.Starred):
                rest = len(items) - (len(targets) - 1 - i)
                items = [*items[:i], tuple_of(items[i:rest]), *items[rest:]]
                targets = [*targets[:i], each.value, *targets[i + 1 :]]
        if len(targets) != len(items):
            raise UntraceableError(f"{len(items)} items for {len(targets)} names")
        for each, item in zip(targets, items, strict=True):
            self.assign(each, item, frame)

    def _name(self, name: str, value: Value, frame: Frame) -> None:
        if name not in frame.cells:
            frame.names[name] = value
            return
        cell = frame.cells[name]
        if cell is None:
            key = frame.key(name, frame.kept_by[name])
            cell = frame.cells[name] = self.cell(self.kind_of(value), key)
        self.keep(cell, value)
        frame.names[name] = cell

    def _augment(self, node: ast.AugAssign, frame: Frame) -> None:
        match node.target:
            case ast.Name():
                value = self.name(node.target.id, frame)
                if isinstance(value.kind, types.Array):
                    raise UntraceableError(f"write {node.target.id}[:] for what is in the array")
                value = self.operation(node.op, value, self.expression(node.value, frame))
                self._name(node.target.id, value, frame)
            case ast.Attribute():
                record = self.expression(node.target.value, frame)
                value = self.attribute(record, node.target.attr)
                value = self.operation(node.op, value, self.expression(node.value, frame))
                self.set_attribute(record, node.target.attr, value)
            case ast.Subscript():
                array = self.expression(node.target.value, frame)
                index = self.index_value(self.index(node.target.slice, frame))
                value = self.item(array, index)
                value = self.operation(node.op, value, self.expression(node.value, frame))
                self.set_item(array, index, value)

    # Loops.

    def _for(self, node: ast.For, frame: Frame) -> Value | None:
        over = self.expression(node.iter, frame)
        if node.orelse:
            raise UntraceableError("else of a loop is not for kernels")
        if isinstance(over.constant, Range):
            begin, end, step = over.constant.bounds
            if begin.known and end.known and step.known:
                numbers: Any = range(*(each.constant for each in over.constant.bounds))
                if len(numbers) < 2 or (len(numbers) <= _UNROLLED and _indexes(node)):
                    return self._unrolled(node, [*map(constant, numbers)], frame)
            self._turns(node, over.constant.bounds, None, frame)
            return None
        if is_tuple(over.kind):
            return self._unrolled(node, self.items(over), frame)
        if not isinstance(over.kind, types.Array) or over.kind.ndim != 1:
            raise UntraceableError(f"a loop over {over.kind or over.constant}")
        self._turns(node, (constant(0), self.call(len, [over]), constant(1)), over, frame)
        return None

    def _unrolled(self, node: ast.For, items: list[Value], frame: Frame) -> Value | None:
        if not _jumps(node.body):
            for item in items:
                self.assign(node.target, item, frame)
                found = self.block(node.body, frame)
                if found is not None or self.builder.block.is_terminated:
                    return found
            return None
        new, after = self._enter(node, frame), self.new_block()
        for item in items:
            more = self.new_block()
            self.assign(node.target, item, frame)
            self._turn(node, (more, after), frame)
            self.builder.position_at_end(more)
        self.builder.branch(after)
        self._after_loop(after, new, frame)
        return None

    def _turns(
        self, node: ast.For, bounds: tuple[Value, Value, Value], array: Value | None, frame: Frame
    ) -> None:
        builder, new = self.builder, self._enter(node, frame)
        first, last, step = (self.content(self.cast(each, types.int64)) for each in bounds)
        before, head, body = builder.block, self.new_block(), self.new_block()
        end, after = self.new_block(), self.new_block()
        builder.branch(head)
        builder.position_at_end(head)
        number = builder.phi(_INTEGER)
        number.add_incoming(first, before)
        goes_on = builder.icmp_signed("<", number, last)
        down = builder.icmp_signed(">", number, last)
        if not bounds[2].known:
            up = builder.icmp_signed(">", step, ir.Constant(_INTEGER, 0))
            goes_on = builder.select(up, goes_on, down)
        elif bounds[2].constant < 0:
            goes_on = down
        builder.cbranch(goes_on, body, after)
        builder.position_at_end(body)
        item = running(types.int64, number)
        outer, frame.names = frame.names, dict(frame.names)
        if array is not None:
            item = self.item(array, item)
        self.assign(node.target, item, frame)
        self._turn(node, (end, after), frame)
        outer.update({k: v for k, v in frame.names.items() if isinstance(v, Cell)})
        frame.names = outer
        builder.position_at_end(end)
        number.add_incoming(builder.add(number, step, flags=("nsw",)), end)
        builder.branch(head)
        self._after_loop(after, new, frame)

    def _while(self, node: ast.While, frame: Frame) -> None:
        new, builder = self._enter(node, frame), self.builder
        head, body, after = self.new_block(), self.new_block(), self.new_block()
        builder.branch(head)
        builder.position_at_end(head)
        frame.loops.append((head, after))
        test = self.condition(node.test, frame)
        frame.loops.pop()
        builder.cbranch(self.content(test), body, after)
        builder.position_at_end(body)
        self._turn(node, (head, after), frame)
        self._after_loop(after, new, frame)
        if test.known and test.constant and after not in self._left:
            builder.unreachable()  # it ends with a return

    def _enter(self, loop: ast.For | ast.While, frame: Frame) -> list[str]:
        """Make cells of what the loop keeps; return their names."""
        assert isinstance(frame.node, ast.FunctionDef)
        new = [name for name in sorted(kept(loop, frame.node)) if name not in frame.cells]
        for name in new:
            value = frame.names.get(name)
            frame.cells[name], frame.kept_by[name] = None, loop.lineno
            if isinstance(value, Value):
                self._name(name, value, frame)
        return new

    def _turn(self, node: ast.For | ast.While, jumps: tuple[Any, Any], frame: Frame) -> None:
        """Emit the body of a loop, which goes on at the first of the blocks `jumps`."""
        outer, frame.names = frame.names, dict(frame.names)
        frame.loops.append(jumps)
        frame.depth += 1
        self.block(node.body, frame)
        frame.depth -= 1
        frame.loops.pop()
        if not self.builder.block.is_terminated:
            self.builder.branch(jumps[0])
        outer.update({k: v for k, v in frame.cells.items() if v is not None})
        frame.names = outer

    def _after_loop(self, after: Any, new: list[str], frame: Frame) -> None:
        """Go on after a loop, with the values that it has left."""
        self.builder.position_at_end(after)
        for name in new:
            cell = frame.cells.pop(name)
            if cell is not None:
                frame.names[name] = self.loaded(cell)


def _jumps(body: Sequence[ast.stmt]) -> bool:
    """Whether statements of a loop jump to its next turn or out of it."""
    return any(
        isinstance(each, ast.Continue | ast.Break)
        or (isinstance(each, ast.If) and (_jumps(each.body) or _jumps(each.orelse)))
        for each in body
    )


def _indexes(node: ast.For) -> bool:
    """Whether the number of a loop is an index, perhaps of a tuple."""
    return isinstance(node.target, ast.Name) and any(
        isinstance(each, ast.Subscript)
        and isinstance(each.slice, ast.Name)
        and each.slice.id == node.target.id
        for each in ast.walk(node)
    )
