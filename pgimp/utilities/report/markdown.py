"""The Markdown of a study's page as HTML: headings, tables, lists, paragraphs, code."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape

from pgimp.utilities.report.html import Markup, items, paragraph, table

_CELL = re.compile(r"(?<!\\)\|")


def to_html(source: str) -> tuple[str, list[Markup]]:
    """Return the title of a page, and the rest of it as HTML, piece by piece."""
    title, found = "", []
    for kind, lines in _pieces(source):
        if kind == "#" and not title:
            title = lines[0].lstrip("# ")
        elif kind == "#":
            found.append(Markup(f"<h3>{_inline(lines[0].lstrip('# '))}</h3>"))
        elif kind == "|":
            head, *rows = (_cells(line) for line in lines)
            texts = bool(rows[1:]) and all(re.match(r"[A-Za-z]{3}", row[1]) for row in rows[1:])
            found.append(table(head, rows[1:], words=2 if texts else 1))
        elif kind == "-":
            found.append(items(_inline(line.removeprefix("- ")) for line in lines))
        else:
            found.append(paragraph(_inline(" ".join(lines))))
    return title, found


def _pieces(source: str) -> Iterator[tuple[str, list[str]]]:
    """Yield runs of lines of a kind, by their first character."""
    kind, lines = "", list[str]()
    for line in [*source.splitlines(), ""]:
        now = line[:1] if line[:1] in ("#", "|", "-") else "text" if line.strip() else ""
        if now != kind or now == "#":
            if lines:
                yield kind, lines
            kind, lines = now, []
        if now:
            lines.append(line)


def _cells(line: str) -> list[Markup]:
    parts = _CELL.split(line.strip().removeprefix("|").removesuffix("|"))
    return [_inline(part.strip().replace("\\|", "|")) for part in parts]


def _inline(words: str) -> Markup:
    """Return a line with its code marked."""
    parts = re.split(r"`([^`]*)`", words)
    shown = [
        f"<code>{escape(part)}</code>" if i % 2 else escape(part) for i, part in enumerate(parts)
    ]
    return Markup("".join(shown))
