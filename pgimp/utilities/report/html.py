"""Pieces of an HTML page that needs nothing else: text, tables, figures; no script, no fonts."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape

#: The first bytes of every report, by which an older one is known.
BEGINNING = "<!DOCTYPE html>\n<!-- A report of pgimp. -->\n"

_STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.2rem; max-width: 58rem; color: #1a1a1a; background: #fff;
  font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 1.65rem; line-height: 1.25; margin: 0 0 .2rem; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .6rem; padding-bottom: .2rem;
  border-bottom: 1px solid #c9ced6; }
h3 { font-size: 1rem; margin: 1.3rem 0 .4rem; }
p { margin: .5rem 0; max-width: 46rem; overflow-wrap: anywhere; }
.sub { color: #555; margin-top: 0; }
nav { font-size: .9rem; margin: .8rem 0; }
nav a { margin-right: .9rem; white-space: nowrap; display: inline-block; }
a { color: #00539b; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .5rem 0 1rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .25rem .8rem .25rem 0;
  border-bottom: 1px solid #e4e7eb; }
th { font-weight: 600; }
thead th { border-bottom: 1px solid #8d96a3; }
td.n, th.n { text-align: right; }
td.n { white-space: nowrap; } td:first-child { min-width: 5.5rem; }
tr.sum td, tr.sum th { border-top: 1px solid #8d96a3; font-weight: 600; }
pre { background: #f5f6f8; border: 1px solid #e4e7eb; padding: .7rem .8rem; margin: .5rem 0;
  font: 12.5px/1.45 ui-monospace, "DejaVu Sans Mono", monospace; white-space: pre-wrap;
  overflow-wrap: anywhere; }
figure { margin: .8rem 0; }
figure svg, figure img { display: block; max-width: 100%; height: auto; }
figcaption { color: #555; font-size: .88rem; margin-top: .25rem; max-width: 46rem; }
.state { display: inline-block; padding: .05rem .55rem; border-radius: .2rem; font-weight: 600;
  border: 1px solid currentColor; }
.done { color: #00684c; } .running, .stopped { color: #7a5600; } .failed { color: #a32a00; }
.alarm { border-left: 4px solid #a32a00; padding-left: .8rem; }
.beyond { color: #a32a00; font-weight: 600; }
.bar { display: inline-block; vertical-align: -.1em; }
ul { margin: .5rem 0; padding-left: 1.2rem; max-width: 46rem; }
li { overflow-wrap: anywhere; }
summary { cursor: pointer; }
footer { margin-top: 2.5rem; color: #555; font-size: .88rem; }
@media (max-width: 40rem) { body { padding: .8rem; font-size: 14px; }
  th, td { padding-right: .5rem; } }
@media print { @page { margin: 16mm 14mm; }
  body { max-width: none; padding: 0; font-size: 9.5pt; }
  nav, .screen { display: none; } a { color: inherit; text-decoration: none; }
  .wide { overflow: visible; }
  h2, h3 { break-after: avoid; } figure, tr, .alarm { break-inside: avoid; }
  th, td { padding-right: .5rem; } pre { font-size: 7.5pt; } td.n { white-space: normal; } }
"""


class Markup(str):
    """Text that is HTML already."""


def text(value: object) -> Markup:
    """Return text with its special characters escaped; HTML stays as it is."""
    return value if isinstance(value, Markup) else Markup(escape(str(value), quote=True))


def join(parts: Iterable[object]) -> Markup:
    """Return pieces, one after the other."""
    return Markup("\n".join(text(part) for part in parts if part != ""))


def paragraph(content: object, kind: str = "") -> Markup:
    """Return a paragraph."""
    return Markup(f"<p{_class(kind)}>{text(content)}</p>")


def block(content: str) -> Markup:
    """Return text in lines of their own, such as a file."""
    return Markup(f"<pre>{text(content)}</pre>")


def items(entries: Iterable[object]) -> Markup:
    """Return a list; nothing without entries."""
    lines = [f"<li>{text(entry)}</li>" for entry in entries]
    return Markup("<ul>\n" + "\n".join(lines) + "\n</ul>") if lines else Markup()


def section(title: str, *parts: object) -> Markup:
    """Return a section with a heading; nothing if all parts are empty."""
    content = join(parts)
    if not content:
        return Markup()
    return Markup(f'<section id="{anchor(title)}">\n<h2>{text(title)}</h2>\n{content}\n</section>')


def anchor(title: str) -> str:
    """Return the anchor of a section."""
    return "".join(c if c.isalnum() else "-" for c in title.lower())


def facts(rows: Iterable[tuple[object, object]]) -> Markup:
    """Return names with their values, a row each; values that are empty are left out."""
    lines = [
        f'<tr><th scope="row">{text(name)}</th><td>{text(value)}</td></tr>'
        for name, value in rows
        if value not in ("", None)
    ]
    return Markup("<table>\n" + "\n".join(lines) + "\n</table>") if lines else Markup()


def table(
    head: Sequence[str], rows: Iterable[Sequence[object]], words: int = 1, sums: int = 0
) -> Markup:
    """Return a table; nothing without rows.

    Parameters
    ----------
    head : sequence of str
        Names of the columns.
    rows : iterable of sequence
        Its cells, as many as columns.
    words : int
        The first columns, which are words; in the others numbers stand at the right.
    sums : int
        Number of rows at the end that are sums.
    """
    found = [list(row) for row in rows]
    if not found:
        return Markup()

    def cells(row: Sequence[object], tag: str) -> str:
        return "".join(
            f"<{tag}{_class('n' if i >= words else '')}>{text(cell)}</{tag}>"
            for i, cell in enumerate(row)
        )

    lines = [f"<thead><tr>{cells(head, 'th')}</tr></thead>", "<tbody>"]
    for i, row in enumerate(found):
        kind = "sum" if i >= len(found) - sums else ""
        lines.append(f"<tr{_class(kind)}>{cells(row, 'td')}</tr>")
    content = "\n".join([*lines, "</tbody>"])
    return Markup(f'<div class="wide"><table>\n{content}\n</table></div>')


def _class(kind: str) -> str:
    return f' class="{kind}"' if kind else ""


def figure(content: Markup, caption: object = "") -> Markup:
    """Return a figure with its caption; nothing without content."""
    if not content:
        return Markup()
    below = f"<figcaption>{text(caption)}</figcaption>" if caption else ""
    return Markup(f"<figure>\n{content}\n{below}</figure>")


def image(png: bytes, description: str, width: int | None = None) -> Markup:
    """Return a PNG as a part of the page."""
    data = base64.b64encode(png).decode()
    size = f' width="{width}"' if width else ""
    return Markup(f'<img alt="{text(description)}"{size} src="data:image/png;base64,{data}">')


def page(title: str, *parts: object) -> str:
    """Return the page with all its parts; contents are made of the sections."""
    return (
        f'{BEGINNING}<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{text(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f"{join(parts)}\n</body>\n</html>\n"
    )


def contents(titles: Sequence[str]) -> Markup:
    """Return links to sections."""
    links = [f'<a href="#{anchor(title)}">{text(title)}</a>' for title in titles]
    return Markup("<nav>" + "\n".join(links) + "</nav>")
