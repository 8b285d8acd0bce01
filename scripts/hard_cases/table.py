"""The tables of README.md and hard.md, from the records of the runs."""

import csv
from pathlib import Path

from rows import METHODS
from runs import ROOT

END = "<!-- end -->"
CASES_MARK = "<!-- written by scripts/hard cases -->\n"
COURANT_MARK = "<!-- written by scripts/hard courant -->\n"


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
    """Method by case."""
    rows = list(dict.fromkeys(record["case"] for record in records))
    found = {(record["case"], record["method"]): record for record in records}
    lines = ["| case | " + " | ".join(METHODS) + " |", "|---" * (len(METHODS) + 1) + "|"]
    for row in rows:
        cells = [entry(found.get((row, method))) for method in METHODS]
        lines.append(f"| {row} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, ""])


def courant_table(points):
    """Largest stable Courant numbers, of all offsets."""
    kinds = list(dict.fromkeys((p["dimension"], p["per_cell"]) for p in points))
    found = {(p["method"], p["dimension"], p["per_cell"]): p["all"] for p in points}
    titles = [f"{d}D, {n} a cell" for d, n in kinds]
    lines = ["| shape | " + " | ".join(titles) + " |", "|---" * (len(kinds) + 1) + "|"]
    for method in dict.fromkeys(p["method"] for p in points):
        limits = [found.get((method, *kind)) for kind in kinds]
        cells = [
            "" if x is None else "at least 1" if x >= 1.0 else f"{x:.2f}" for x in limits
        ]
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, ""])


def put_between(start, text):
    """Replace what README.md has between a mark and the next end mark."""
    path = ROOT / "README.md"
    before, mark, rest = path.read_text(encoding="utf-8").partition(start)
    _, end, after = rest.partition(END)
    if not (mark and end):
        raise SystemExit(f"hard: README.md lacks the marks {start.strip()} and {END}")
    path.write_text(before + mark + text + end + after, encoding="utf-8")


def write_csv(records, path: Path):
    """Write all records as they are."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(records[0]))
        writer.writeheader()
        writer.writerows(records)
