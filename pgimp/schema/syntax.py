"""Messages for errors of the YAML parser, with the usual cause."""

from __future__ import annotations

import re

from ruamel.yaml.error import MarkedYAMLError, StreamMark

from pgimp.schema.words import lookalikes

_NO_SPACE = re.compile(r"""^\s*(?:-\s+)?([A-Za-z][A-Za-z0-9_-]*):(?![\s/])[^\s'"].*$""")


def explain_syntax(error: MarkedYAMLError, text: str, filename: str) -> str:
    """Return file, line, column and the problem; for an override its text instead.

    Parameters
    ----------
    error : MarkedYAMLError
        The parser's error.
    text : str
        The parsed text.
    filename : str
        Name for the message.
    """
    mark = error.problem_mark or error.context_mark
    problem, context = error.problem or "", error.context or ""
    start = error.context_mark.line + 1 if error.context_mark else mark.line + 1
    found = _foreign_space(text, max(start - 2, 0), mark.line)
    if not found and "flow" not in context:
        found = _missing_space(text, mark.line)
    found = found or _cause(problem, context, start)
    return f"{position(filename, mark)}: {found}"


def position(name: str, mark: StreamMark) -> str:
    """Return file, line and column of a mark; for an override only its text."""
    return name if name.startswith("--set ") else f"{name}:{mark.line + 1}:{mark.column + 1}"


def _foreign_space(text: str, first: int, last: int) -> str | None:
    """Return the message for a space of another kind in the structure of these lines."""
    for n, line in enumerate(text.splitlines()[first : last + 1], first + 1):
        if match := lookalikes.IN_STRUCTURE.search(line):
            name = lookalikes.named(match[1] or match[2])
            return f"{name} in line {n}, as text from a web page has; type ordinary spaces instead"
    return None


def _missing_space(text: str, line: int) -> str | None:
    """Return the message for a missing space, ``end:2.0``, in the line of the error or before."""
    lines = text.splitlines()
    for n in (line, line - 1):
        if 0 <= n < len(lines) and (match := _NO_SPACE.match(lines[n])):
            return f"a space is missing after the colon of '{match[1]}:' in line {n + 1}"
    return None


def _cause(problem: str, context: str, start: int) -> str:
    """Return the usual cause of the parser's `problem`; `start` is its first line."""
    if "'\\t'" in problem:
        return "a tab; indent with spaces only"
    if "mapping values are not allowed" in problem:
        return (
            "a colon that cannot stand here: the line is indented deeper than the one before, "
            "or it has two colons (text with a colon needs quotes)"
        )
    if "sequence entries are not allowed" in problem:
        return "a list item cannot start here: put it on a line of its own, or write [a, b]"
    if "<block end>" in problem:
        if "'<scalar>'" in problem or "'<flow" in problem:
            return "this does not belong here: is a quote, comma or colon missing before it?"
        return f"the indentation does not fit the block that starts in line {start}"
    if "could not find expected ':'" in problem:
        return f"a key without a colon in line {start}"
    if "expected ',' or" in problem:
        closing = "]" if "sequence" in context else "}"
        return f"a ',' or the closing '{closing}' is missing after line {start}"
    if "unexpected end of stream" in problem and "quoted" in context:
        return f"the quote that opens in line {start} is not closed"
    if "expected '<document start>'" in problem:
        return "this does not continue what stands above: is there a stray bracket, quote or %?"
    if "found '<stream end>'" in problem:
        return "it ends in the middle of a list or a mapping"
    if "cannot start any token" in problem:
        return f"text that starts with {problem.split()[2]} needs quotes"
    return f"not valid YAML: {problem or 'cannot be read'}"
