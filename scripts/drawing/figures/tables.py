"""The errors of all runs as a table: errors.csv, and errors.md to read."""

from studies.harness import table, write_csv

from figures.convergence import COUNTS, SPEEDS, line_of, speed_of
from figures.methods import METHODS
from figures.profiles import FRACTIONS, INSTANTS, column_run, shock_run

FIELDS = (
    "problem", "method", "entry", "cell", "particles-per-cell", "step", "speed", "time", "error",
    "error_dynamic", "worst", "mean_behind", "jump_behind", "particles", "steps", "seconds",
    "state",
)  # fmt: skip
NOTES = """\
`error` is (47): for the column against statics (42), for the shock against the sharp front (46),
relative to 20000. `error_dynamic` is against the solution with the waves that the ramp sends
through the column. `worst` is the largest deviation of a particle's stress from (42) as a part of
W; `mean_behind` and `jump_behind` are the mean stress behind the shock and the largest difference
between neighbours there. `seconds` are those of one core, measured beside other runs: compare
methods by `scripts/pictures error-and-cost`.
"""


def write(results, origin, folder):
    found = [row(run, record) for run, records in results.items() for record in records]
    write_csv(found, folder / "errors.csv")
    parts = ["# Errors of the paper's examples\n", f"{origin}\n", NOTES, *sections(results)]
    (folder / "errors.md").write_text("\n".join(parts), encoding="utf-8")


def row(run, record):
    """A run at an instant, as a row of errors.csv."""
    names = {"error_dynamic": "dynamic", "mean_behind": "mean", "jump_behind": "jump"}
    found = {field: record.get(names.get(field, field)) for field in FIELDS}
    return found | {
        "problem": run.problem, "method": run.method, "entry": METHODS[run.method].entry,
        "cell": run.cell, "particles-per-cell": run.per_cell, "step": run.step, "speed": run.speed,
        "time": record["time"], "seconds": round(record["seconds"], 3),
        "state": record.get("stopped", "done"),
    }  # fmt: skip


def sections(results):
    """The tables of errors.md."""
    heads = [f"W = {20000 * time:.0f}" for time in INSTANTS]
    yield "## Figures 4 and 5: column, cells of 1, 2 particles per cell: error, worst particle\n"
    rows = []
    for run in (column_run("mpm", 1e-4), *map(column_run, METHODS)):
        entries = [entry(r, "error", "worst") for r in results[run]]
        rows.append((f"{METHODS[run.method].label}, step {run.step:g}", *entries))
    yield table(("method", *heads), rows)

    yield "## Figures 6 to 9: shock, cells of 1: error, mean stress and largest jump behind it\n"
    heads = [f"t = {fraction:g} transits" for fraction in FRACTIONS]
    rows = []
    for method in METHODS:
        for n in COUNTS:
            entries = [entry(r, "error", "mean", "jump") for r in results[shock_run(method, n)]]
            rows.append((f"{METHODS[method].label}, {n} p/c", *entries))
    yield table(("method", *heads), rows)

    yield "## Figure 10: column at W = 10000\n"
    lines = {(m, n): line_of(results, m, n) for m in METHODS for n in COUNTS}
    lines = {key: line for key, line in lines.items() if line}
    cells = list(next(iter(lines.values())))
    rows = [
        (
            f"{METHODS[m].label}, {n} p/c",
            *(entry(line[cell], "error") if cell in line else "" for cell in cells),
        )
        for (m, n), line in lines.items()
    ]
    yield table(("cell", *(f"{cell:g}" for cell in cells)), rows)

    yield "## Figure 11: Finite GIMP, 1 p/c: the ramp's speed\n"
    rows = []
    for speed in SPEEDS:
        line = speed_of(results, speed)
        kinds = ((0, "error", "W = 10000"), (1, "error", "a transit later"))
        for k, key, place in (*kinds, (1, "dynamic", "a transit later, with the waves")):
            entries = [entry(line[c][k], key) if c in line else "" for c in cells]
            rows.append((f"speed {speed:g}, {place}", *entries))
    yield table(("cell", *(f"{cell:g}" for cell in cells)), rows)


def entry(record, *keys):
    """What a record says, or that its run stopped."""
    if "stopped" in record:
        return record["stopped"].split(":")[0]
    return ", ".join(
        f"{record[key]:.0f}" if key in ("mean", "jump") else f"{record[key]:.2e}" for key in keys
    )
