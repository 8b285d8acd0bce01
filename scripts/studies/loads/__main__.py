"""Measures loads on surfaces; see scripts/loads."""

from studies.harness import options_of, origin, table
from studies.loads import chuck, edges, moving, sea, tube

#: Pressures over Young's modulus: small strain, and a bore that grows by half.
SMALL, LARGE = 1e-4, 0.15


def tubes(pressure, exact):
    """Rows of a tube under a pressure, by configuration, particles and cells."""
    rows = []
    for configuration, per_cell in (("initial", 2), ("current", 2), ("current", 3)):
        for cells in (8, 16):
            found = tube.blown(cells, configuration, pressure, exact, per_cell)
            words = ", 3 x 3 particles a cell" * (per_cell == 3)
            rows.append([f"`{configuration}`{words}, {cells} cells a radius", *found])
    return rows


def crossing(cells):
    """Row of a beam that a load crosses."""
    mean, most, peak, lost, steps, took = moving.crossed(cells)
    parts = f"{100 * mean:.1f} %", f"{100 * most:.1f} %", f"{100 * peak:+.1f} %", f"{lost:.0e}"
    return [cells, *parts, steps, f"{took:.1f} s"]


def main():
    """Measure what is asked for, and print its tables."""
    what = {"nargs": "*", "among": ("bore", "blown", "sea", "moving", "chuck", "edges")}
    options = options_of("loads", what=what | {"metavar": "WHAT"})
    chosen = options.what or what["among"]
    measured = f"Measured by `scripts/loads` on one core of {origin()}."
    titles = ["tube", "displacement at the bore", "everywhere, root mean square", "load", "steps",
              "time"]  # fmt: skip
    if "bore" in chosen:
        print(table(titles, tubes(SMALL, tube.lame(SMALL)), measured))
    if "blown" in chosen:
        print(table(titles, tubes(LARGE, tube.shot(LARGE)), measured))
    if "sea" in chosen:
        rows = [[name, f"{sea.error(*entry):.0e}"] for name, entry in sea.BODIES.items()]
        print(table(["body under water", "error of the force"], rows, measured))
    if "moving" in chosen:
        titles = ["cells of the height", "deflection of the middle, root mean square", "greatest",
                  "greatest deflection", "energy less work", "steps", "time"]  # fmt: skip
        print(table(titles, [crossing(cells) for cells in (2, 4)], measured))
    if "chuck" in chosen:
        titles = ["block, after", "radii, held", "radii, free", "angular momentum", "energy",
                  "work a turn", "steps", "time"]  # fmt: skip
        rows = [*chuck.watched("initial"), *chuck.watched("current")]
        print(table(titles, rows, measured))
    if "edges" in chosen:
        titles = ["configuration, part of the mass", "bar pulled", "bar carried", "bent by 0.01",
                  "bent by 1", "disk", "jumps"]  # fmt: skip
        print(table(titles, edges.rows(), measured))


if __name__ == "__main__":
    main()
