"""The tables of docs/methods.md from what was measured."""

import csv
import os
import subprocess
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path

from studies.method.measures import COLUMN_CELLS, COURANTS

from pgimp.io.rundir.runinfo import cpu

ROOT = Path(__file__).resolve().parents[3]
#: What scripts/pages writes pages from, and the tables of this script among it.
PAGES = ROOT / "scripts" / "pages"
TABLES = PAGES / "tables" / "methods.md"


def origin():
    """Machine, versions and date."""
    versions = ", ".join(f"{name} {version(name)}" for name in ("pgimp", "numba", "numpy"))
    return f"{cpu()} ({os.cpu_count()} cores), {versions}, {date.today()}"


def number(value, sign=False):
    """A part as per cent, two digits."""
    if value is None:
        return "stopped"
    percent = 100.0 * value
    if abs(percent) < 0.005:
        return "0"
    digits = 0 if abs(percent) >= 9.95 else 1 if abs(percent) >= 0.095 else 2
    return f"{percent:{'+' if sign else ''}.{digits}f}"


def joined(values, sign=False):
    """Some numbers in a cell of the table."""
    texts = [number(value, sign) for value in values]
    return "stopped" if set(texts) == {"stopped"} else ", ".join(texts)


def name(record):
    """Label of a method."""
    affine = ", affine" if record["affine"] else ""
    return f"{record['shape']}{affine}, {record['per_cell']} a cell"


def accuracy(records):
    """Errors and cost by method: 2D and 3D, or the column's three cells, in one place each."""

    def cost(record):
        costs = [(record.get(f"cost {D}"), record.get(f"plain {D}")) for D in (2, 3)]
        return ", ".join("" if None in pair else f"{pair[0] / pair[1]:.2f}" for pair in costs)

    def cell(record, keys, sign=False):
        return joined([record.get(key) for key in keys], sign)

    columns = {
        "method": name,
        "bending": lambda r: cell(r, ["frequency 2", "frequency 3"], True),
        "swing": lambda r: cell(r, [f"swing {COURANTS[0]} 2", f"swing {COURANTS[0]} 3"]),
        "wave speed": lambda r: cell(r, ["speed"], True),
        "bounce": lambda r: cell(r, ["bounce 2", "bounce 3"]),
        "spin": lambda r: cell(r, [f"spin {COURANTS[0]} 2", f"spin {COURANTS[0]} 3"]),
        "compression": lambda r: cell(r, [f"column {c}" for c in COLUMN_CELLS]),
        "cost": cost,
    }
    return table(columns, records)


def losses(records):
    """Energy and spin that are lost in a period or turn, by Courant number, in 2D."""

    def of(what, suffix=""):
        keys = [f"{what} {courant}{suffix}" for courant in COURANTS]
        return lambda record: joined([record.get(key) for key in keys])

    columns = {
        "method": name,
        "swing": of("swing", " 2"),
        "spin": of("spin", " 2"),
        "wave": of("wave"),
    }
    return table(columns, [record for record in records if record["per_cell"] == 2])


def table(columns, records):
    """Markdown."""
    lines = ["| " + " | ".join(columns) + " |", "|---" * len(columns) + "|"]
    lines += ["| " + " | ".join(word(r) for word in columns.values()) + " |" for r in records]
    return "\n".join([*lines, ""])


def text(records, machine):
    """All tables of docs/methods.md."""
    return (
        f"{accuracy(records)}\nLost at Courant numbers of "
        f"{', '.join(map(str, COURANTS))}, in 2D:\n\n{losses(records)}\n"
        f"Measured on one core of {machine}.\n"
    )


def added(records, machine):
    """The tables of the docs with the lines of these methods added, or in their place."""
    parts = TABLES.read_text(encoding="utf-8").split("\n\n")
    for i, table in enumerate((accuracy(records), losses(records))):
        at = 2 * i
        lines = parts[at].rstrip("\n").split("\n")
        new = {line.split(" | ")[0]: line for line in table.rstrip("\n").split("\n")[2:]}
        kept = [new.pop(line.split(" | ")[0], line) for line in lines]
        parts[at] = "\n".join([*kept, *new.values()])
    shapes = ", ".join(dict.fromkeys(record["shape"] for record in records))
    head = f"The lines of {shapes}:"
    note = f"{head} {machine}."
    said = [line for line in parts[3].splitlines() if not line.startswith(head)]
    parts[3] = "\n".join([*said, note]) + "\n"
    return "\n\n".join(parts)


def put_into_docs(text):
    """Write docs/methods.md with these tables."""
    TABLES.write_text(text, encoding="utf-8")
    subprocess.run([sys.executable, str(PAGES)], check=True)


def write_csv(records, path):
    """All numbers as they are."""
    keys = list(dict.fromkeys(key for record in records for key in record))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, keys)
        writer.writeheader()
        writer.writerows(records)
