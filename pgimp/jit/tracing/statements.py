"""Statements of a kernel."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

from numba.core import errors

from pgimp.jit.tracing.frame import Frame
from pgimp.jit.tracing.loops import Loops
from pgimp.jit.tracing.source import living
from pgimp.jit.tracing.values import NONE, Cell, UntraceableError, Value

#: Errors that become errors of the kernel, with a place.
_OTHERS = (
    ArithmeticError, AssertionError, AttributeError, LookupError, NotImplementedError, TypeError,
    ValueError, errors.NumbaError,
)  # fmt: skip


class Tracer(Loops):
    """Walk over the statements of a kernel and of all that it calls."""

    def block(self, body: Sequence[ast.stmt], frame: Frame) -> Value | None:
        """Emit statements; return the function's result if it is known at their end."""
        for each in body:
            try:
                found = self._statement(each, frame)
            except UntraceableError as error:
                self._place(error, each, frame)
                raise
            except _OTHERS as error:  # of Python's functions and of Numba
                mine = UntraceableError(f"{type(error).__name__}: {error}")
                self._place(mine, each, frame)
                raise mine from error
            if found is not None:
                return found
            if self.builder.block.is_terminated:
                break
        return None

    def _place(self, error: Exception, node: ast.stmt, frame: Frame) -> None:
        file, name = frame.function.__code__.co_filename, frame.function.__qualname__
        error.add_note(f"{file}:{node.lineno}, in {name}")

    def _statement(self, node: ast.stmt, frame: Frame) -> Value | None:
        match node:
            case ast.Assign():
                value = self.typed(self.expression(node.value, frame))
                for target in node.targets:
                    self.assign(target, value, frame)
            case ast.AugAssign():
                self._augment(node, frame)
            case ast.AnnAssign() if node.value:
                self.assign(node.target, self.typed(self.expression(node.value, frame)), frame)
            case ast.If():
                return self._branch(node, frame)
            case ast.For():
                return self._for(node, frame)
            case ast.While():
                self._while(node, frame)
            case ast.Return():
                value = self.typed(self.expression(node.value, frame)) if node.value else NONE
                if frame.exit is None and not frame.depth:
                    return value
                self.leave(value, frame)
            case ast.Continue():
                self.builder.branch(frame.loops[-1][0])
            case ast.Break():
                self.builder.branch(frame.loops[-1][1])
                self._left.add(frame.loops[-1][1])
            case ast.Expr():
                if not isinstance(node.value, ast.Constant):
                    self.expression(node.value, frame)
            case ast.Pass():
                pass
            case _:
                raise UntraceableError(f"{type(node).__name__} is not for kernels")
        return None

    # Branches.

    def _branch(self, node: ast.If, frame: Frame) -> Value | None:
        test = self.condition(node.test, frame)
        if test.known:
            return self.block(node.body if test.constant else node.orelse, frame)
        blocks, after = (self.new_block(), self.new_block()), self.new_block()
        self.builder.cbranch(self.content(test), *blocks)
        before, ends = frame.names, []
        frame.depth += 1
        for block, body in zip(blocks, (node.body, node.orelse), strict=True):
            self.builder.position_at_end(block)
            frame.names = dict(before)
            self.block(body, frame)
            if not self.builder.block.is_terminated:
                ends.append((frame.names, self.builder.block))
                self.builder.branch(after)
        frame.depth -= 1
        self.builder.position_at_end(after)
        if not ends:
            self.builder.unreachable()
            return None
        frame.names = ends[0][0]
        if len(ends) == 2:
            self._meet(ends, self._living(node, frame), frame)
        return None

    def _living(self, node: ast.stmt, frame: Frame) -> frozenset[str]:
        assert isinstance(frame.node, ast.FunctionDef)
        return living(frame.node)[node]

    def _meet(self, ends: list[tuple[dict, Any]], names: frozenset[str], frame: Frame) -> None:
        """Make one of the variables of two branches that are still read."""
        (one, _), (other, _) = ends
        for name in {**one, **other}:
            first, second = one.get(name), other.get(name)
            if first is second:
                continue
            if isinstance(first, Cell) or isinstance(second, Cell):
                frame.names[name] = first or second
            elif name in names:
                meeting = [(found.get(name), block) for found, block in ends]
                try:
                    frame.names[name] = self.met(meeting)
                except UntraceableError:  # of two types: an error if it is read
                    frame.names[name] = None
