"""The tables of docs/methods.md from what was measured."""

from studies import harness
from studies.method.measures import COLUMN_CELLS, COURANTS

#: The tables of this script.
TABLES = harness.TABLES / "methods.md"


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
    texts = [number(value, sign) for value in values]
    return "stopped" if set(texts) == {"stopped"} else ", ".join(texts)


def name(record):
    parts = [record["shape"], *["affine"] * record["affine"]]
    if record["configuration"] != "current":
        parts.append(record["configuration"])
    return ", ".join([*parts, f"{record['per_cell']} a cell"])


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
        "method": name, "swing": of("swing", " 2"), "spin": of("spin", " 2"), "wave": of("wave"),
    }  # fmt: skip
    return table(columns, [record for record in records if record["per_cell"] == 2])


def table(columns, records):
    return harness.table(columns, ([word(r) for word in columns.values()] for r in records))


def text(records, machine):
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
    names = ", ".join(dict.fromkeys(name(record).rpartition(", ")[0] for record in records))
    head = f"The lines of {names}:"
    note = f"{head} {machine}."
    said = [line for line in parts[3].splitlines() if not line.startswith(head)]
    parts[3] = "\n".join([*said, note]) + "\n"
    return "\n\n".join(parts)
