"""Source of functions as syntax trees, and the names that live beyond a branch or a loop."""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType

from pgimp.jit.tracing.values import UntraceableError

Function = ast.FunctionDef | ast.Lambda
Names = frozenset[str]
_NOTHING: Names = frozenset()


@cache
def _functions(path: str) -> dict[int, list[Function]]:
    """Functions of a file by their first line."""
    found: dict[int, list[Function]] = {}
    for node in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Lambda):
            found.setdefault(node.lineno, []).append(node)
        elif isinstance(node, ast.FunctionDef):
            first = node.decorator_list[0] if node.decorator_list else node
            found.setdefault(first.lineno, []).append(node)
    return found


@cache
def _of_code(code: CodeType) -> Function:
    """Syntax tree of the function with some code."""
    wanted = code.co_varnames[: code.co_argcount]
    found = [
        node
        for node in _functions(code.co_filename).get(code.co_firstlineno, ())
        if isinstance(node, ast.Lambda) == (code.co_name == "<lambda>")
        and tuple(each.arg for each in node.args.args) == wanted
    ]
    if len(found) > 1:  # lambdas on one line: the one around an instruction
        found = [node for node in found if any(_is_within(p, node) for p in code.co_positions())]
    if len(found) != 1:
        raise UntraceableError(f"the source of {code.co_qualname} is not unique")
    return found[0]


def _is_within(place: tuple[int | None, ...], node: Function) -> bool:
    body = node.body
    if None in place or isinstance(body, list) or body.end_lineno is None:
        return False
    first, last = (body.lineno, body.col_offset), (body.end_lineno, body.end_col_offset or 0)
    line, end_line, column, end_column = (each or 0 for each in place)
    return place[3] != 0 and first <= (line, column) and (end_line, end_column) <= last


def source_of(function: FunctionType) -> Function:
    """Syntax tree of a function.

    Raises
    ------
    UntraceableError
        If it cannot be found.
    """
    try:
        return _of_code(function.__code__)
    except OSError as error:
        raise UntraceableError(f"the source of {function.__qualname__} is missing") from error


@cache
def stored(node: ast.AST) -> Names:
    """Names that a statement gives a value; those of a generator are its own."""
    loops = [each.target for each in ast.walk(node) if isinstance(each, ast.comprehension)]
    own = {each for target in loops for each in ast.walk(target)}
    return frozenset(
        each.id
        for each in ast.walk(node)
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store) and each not in own
    )


@cache
def _read(node: ast.AST | None) -> Names:
    if node is None:
        return _NOTHING
    return frozenset(
        each.id
        for each in ast.walk(node)
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Load)
    )


@cache
def living(function: ast.FunctionDef) -> dict[ast.stmt, Names]:
    """Names still read after each ``if`` of a function; after or in the next turn of each loop."""
    found: dict[ast.stmt, Names] = {}
    _before(function.body, _NOTHING, (_NOTHING, _NOTHING), found)
    return found


def _before(
    body: Iterable[ast.stmt], after: Names, loop: tuple[Names, Names], found: dict[ast.stmt, Names]
) -> Names:
    """Names read from the beginning of `body` on, before they get a value.

    `after` is the same at its end, and `loop` where it goes on with the loop's next turn and where
    it leaves the loop.
    """
    for each in reversed([*body]):
        match each:
            case ast.If():
                found[each] = after
                ends = [_before(part, after, loop, found) for part in (each.body, each.orelse)]
                after = _read(each.test) | ends[0] | ends[1]
            case ast.For() | ast.While():
                test = _read(each.test) if isinstance(each, ast.While) else _NOTHING
                targets = stored(each.target) if isinstance(each, ast.For) else _NOTHING
                head = after | test
                for _ in range(2):  # what the first turn reads of the one before
                    head |= _before(each.body, head, (head, after), found) - targets
                found[each] = head
                after = head | (_read(each.iter) if isinstance(each, ast.For) else _NOTHING)
            case ast.Return():
                after = _read(each.value)
            case ast.Continue():
                after = loop[0]
            case ast.Break():
                after = loop[1]
            case ast.AugAssign():
                after = after | _read(each) | stored(each)
            case _:
                after = (after - stored(each)) | _read(each)
    return after


@cache
def kept(loop: ast.For | ast.While, function: ast.FunctionDef) -> Names:
    """Names that a loop gives a value for its next turn, or for what follows it."""
    given = frozenset().union(*map(stored, loop.body))
    if isinstance(loop, ast.For):
        given |= stored(loop.target)
    return given & living(function)[loop]
