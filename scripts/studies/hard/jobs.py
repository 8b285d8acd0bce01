"""What the processes of scripts/hard do, one job at a time."""

from itertools import product

from studies.hard.courant import SPEEDS, limits, moving_limit
from studies.hard.locking import KINDS, OFFSETS, locked
from studies.hard.locking import METHODS as UNLOCKED
from studies.hard.rows import METHODS, ROWS, grazed, measured

#: Not in 1D, where they are as without, or there is no Poisson's ratio.
MEAN = (
    "gimp, mean", "gimp, mean, affine", "gimp, 0.499", "gimp, mean, 0.4", "gimp, mean, 0.45",
    "gimp, mean, 0.499",
)  # fmt: skip


def case_job(number, method, quick):
    """A run of the table; a row past the last is that of the grazing bars."""
    if number == len(ROWS):
        return grazed(method)
    return measured(ROWS[number], method, quick)


def courant_job(method, dimension, per_cell, quick):
    """A point of the map."""
    steps = 500 if quick else 4000 if dimension == 1 else 1500
    shape, *words = method.split(", ")
    entry = {"shape": shape, "affine": "affine" in words}
    if "mean" in words:
        entry["volumetric"] = "b-bar"
    poisson = next((float(word) for word in words if word.startswith("0.")), 0.3)
    both = limits(entry, dimension, per_cell, steps, 0.05 if quick else 0.01, poisson)
    return {
        "method": method, "dimension": dimension, "per_cell": per_cell, "all": both[0],
        "best": both[1],
    }  # fmt: skip


def moving_job(method, dimension, per_cell, speed, quick):
    """Largest stable steps of bodies that move, in terms of waves alone: dt c/L."""
    shape, _, affine = method.partition(", ")
    entry = {"shape": shape, "affine": bool(affine)}
    found = moving_limit(entry, dimension, per_cell, speed, 0.05 if quick else 0.01)
    return {"method": method, "dimension": dimension, "per_cell": per_cell, "speed": speed,
            "waves": found}  # fmt: skip


def jobs(quick, words, only=()):
    """Every job with the key that it is kept by; with `only`, of these shapes alone."""
    found = {}

    def wanted(method):
        return not only or method.partition(", ")[0] in only

    methods = [m for m in METHODS if wanted(m)]
    if "cases" in words:
        rows = [i for i, row in enumerate(ROWS) if not quick or row.quick is not None]
        for number in (*rows, len(ROWS)):
            known = ROWS[number].methods if number < len(ROWS) else tuple(METHODS)
            label = ROWS[number].label if number < len(ROWS) else "grazing"
            mine = [m for m in known if m in methods]
            found |= {("case", label, m): (case_job, number, m, quick) for m in mine}
    transfers = [m + affine for affine in ("", ", affine") for m in methods]
    if "courant" in words or "mean" in words:
        # With affine mpm gains energy near every surface: no step is stable.
        plain = [m for m in transfers if m != "mpm, affine"] if "courant" in words else ()
        for dimension, most in ((1, 8),) if quick else ((1, 8), (2, 4), (3, 2)):
            means = [m for m in MEAN if dimension > 1 and wanted(m)]
            for per_cell in (n for n in (1, 2, 4, 8) if n <= most):
                for m in (*plain, *means):
                    key = ("courant", dimension, per_cell, m)
                    found[key] = (courant_job, m, dimension, per_cell, quick)
    if "moving" in words:
        for m in (m for m in transfers if not m.startswith("mpm")):
            for speed in SPEEDS:
                found["moving", m, speed] = (moving_job, m, 1, 2, speed, quick)
    if "locking" in words and not only:
        for kind in KINDS[: 1 if quick else None]:
            for method, offset in product(UNLOCKED, OFFSETS[: 1 if quick else None]):
                found["locking", *kind, method, offset] = (locked, method, *kind, offset)
    return found
