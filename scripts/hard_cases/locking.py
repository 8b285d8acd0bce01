"""The cantilever of cases/hard/bending.yaml at several places of its lattice on the grid."""

from rows import deflection
from runs import begin, watch

#: Heights of the lattice above its place in the case, in cells; 1 less them mirror these.
OFFSETS = (0.0, 0.11, 0.23, 0.36, 0.5)

POISSONS, CELLS = (0.3, 0.499, 0.4999), (0.25, 0.125)

_MEAN = {"method.volumetric": "mean"}
METHODS = {
    "gimp": {"method.shape": "gimp"},
    "gimp, mean": {"method.shape": "gimp"} | _MEAN,
    "gimp, mean, affine": {"method.shape": "gimp", "method.affine": True} | _MEAN,
    "finite-gimp, mean": {"method.shape": "finite-gimp"} | _MEAN,
    "cpdi, mean": {"method.shape": "cpdi"} | _MEAN,
}


def locked(method, poisson, cell, offset):
    """Record of one run: its deflection over that of finite elements, less 1; None if it failed."""
    changes = {"materials.rubber.poisson": poisson, "grid.cell": [cell, cell]}
    sim = begin("bending", METHODS[method] | changes)
    p, rows = sim.particles, sim.live()
    for place in (p.x, p.origin):
        place[rows, 1] += offset * cell
    sim.population.sort()
    run = watch(sim)
    found, exact = deflection(run, 1.0 + offset * cell)
    return {
        "method": method,
        "poisson": poisson,
        "cell": cell,
        "offset": offset,
        "error": found / exact - 1.0 if run.stable else None,
        "growth": run.growth,
        "fault": run.fault,
        "steps": run.sim.step,
        "seconds": run.seconds,
    }


def locking_table(records):
    """Least and greatest error over the offsets, by method; columns are materials and cells."""
    kinds = [(poisson, cell) for poisson in POISSONS for cell in CELLS]
    titles = [f"{poisson:g}, {round(1.0 / cell)} cells" for poisson, cell in kinds]
    lines = ["| method | " + " | ".join(titles) + " |", "|---" * (len(kinds) + 1) + "|"]
    for method in METHODS:
        cells = []
        for kind in kinds:
            found = [
                record["error"] for record in records
                if (record["method"], record["poisson"], record["cell"]) == (method, *kind)
            ]  # fmt: skip
            text = ""
            if None in found:
                text = "**unstable**"
            elif found:
                text = f"{100.0 * min(found):+.1f} to {100.0 * max(found):+.1f}"
            cells.append(text)
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, ""])
