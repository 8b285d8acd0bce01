"""The tables of docs/hard-cases.md and hard.md, from the records of the runs."""

from studies.hard.rows import METHODS
from studies.harness import ROOT, TABLES, table


def entry(record):
    """Error and growth of a run that is stable, else why it is not."""
    if record is None:
        return ""
    growth = f"{record['growth']:.0e}".replace("e-0", "e-") if record["growth"] > 0.0 else "0"
    error = "" if record["error"] is None else f"{record['error']:.2g}"
    if record["stable"]:
        return f"{error} ({growth})" if error else f"stable ({growth})"
    if record["fault"]:
        done = "" if record["done"] >= 1.0 else f" at {100.0 * record['done']:.0f} %"
        return f"**{record['fault']}{done}**"
    return f"**energy grows by {record['growth']:.0%}**, {error}"


def cases_table(records):
    rows = list(dict.fromkeys(record["case"] for record in records))
    found = {(record["case"], record["method"]): record for record in records}
    methods = [m for m in METHODS if any(key[1] == m for key in found)]
    lines = [(row, *(entry(found.get((row, method))) for method in methods)) for row in rows]
    return table(("case", *methods), lines)


def courant_table(points):
    """Largest stable Courant numbers, of all offsets."""
    kinds = list(dict.fromkeys((p["dimension"], p["per_cell"]) for p in points))
    found = {(p["method"], p["dimension"], p["per_cell"]): p["all"] for p in points}
    titles = [f"{d}D, {n} a cell" for d, n in kinds]
    lines = []
    for method in dict.fromkeys(p["method"] for p in points):
        limits = [found.get((method, *kind)) for kind in kinds]
        cells = ("" if x is None else "at least 1" if x >= 1.0 else f"{x:.2f}" for x in limits)
        lines.append((method, *cells))
    return table(("shape", *titles), lines)


def moving_table(points):
    """Largest stable dt c/L by speed."""
    speeds = list(dict.fromkeys(p["speed"] for p in points))
    found = {(p["method"], p["speed"]): p["waves"] for p in points}
    titles = ["at rest" if v == 0.0 else f"{v:g} c" for v in speeds]
    methods = dict.fromkeys(p["method"] for p in points)
    lines = [(method, *(f"{found[method, v]:.2f}" for v in speeds)) for method in methods]
    return table(("shape", *titles), lines)


def _cells(text):
    """Titles of a table's columns, and its cells by row and column."""
    rows = [
        [cell.strip() for cell in line.strip("| ").split(" | ")]
        for line in text.splitlines()
        if line.startswith("|") and not line.startswith("|--")
    ]
    titles = rows[0]
    return titles, {row[0]: dict(zip(titles[1:], row[1:], strict=False)) for row in rows[1:]}


def merged(name, text):
    """The table of the docs with rows and columns of another one added, or in their place."""
    path = TABLES / f"{name}.md"
    if not path.exists():
        return text
    (old, cells), (new, more) = _cells(path.read_text(encoding="utf-8")), _cells(text)
    titles = [*old, *(title for title in new if title not in old)]
    if name == "courant":
        titles[1:] = sorted(titles[1:])
    if name == "hard-cases":
        titles = [titles[0], *(m for m in METHODS if m in titles)]
    for row, values in more.items():
        cells[row] = cells.get(row, {}) | {title: cell for title, cell in values.items() if cell}
    lines = [(row, *(values.get(t, "") for t in titles[1:])) for row, values in cells.items()]
    return table(titles, lines)


def limits_of(text):
    """Largest stable Courant numbers by method, dimensions and particles a cell, from the table."""
    found = {}
    for method, cells in _cells(text)[1].items():
        if method.partition(", ")[2] not in ("", "affine"):  # of mean dilatation: `Shape.stable`
            continue
        for title, cell in cells.items():
            dimensions, per_cell = int(title[0]), int(title.split()[1])
            if cell and not method.startswith("mpm"):  # for which there is none
                limit = 1.0 if cell == "at least 1" else float(cell)
                found.setdefault(method, {}).setdefault(dimensions, {})[per_cell] = limit
    return {
        method: {D: dict(sorted(limits.items())) for D, limits in sorted(by.items())}
        for method, by in found.items()
    }


def write_limits(text, path=ROOT / "pgimp" / "physics" / "shapes" / "courant.py"):
    """Put the table's numbers where `courant: auto` finds them."""
    head = path.read_text(encoding="utf-8").partition("LIMITS:")[0]
    lines = ["LIMITS: dict[str, dict[int, dict[int, float]]] = {"]
    for method, by in limits_of(text).items():
        lines.append(f'    "{method}": {{')
        lines += [f"        {D}: {limits!r}," for D, limits in by.items()]
        lines.append("    },")
    path.write_text("\n".join([head + lines[0], *lines[1:], "}", ""]), encoding="utf-8")
