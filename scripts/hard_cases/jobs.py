"""What the processes of scripts/hard do, one job at a time."""

from itertools import product

from courant import limits
from locking import KINDS, OFFSETS, locked
from locking import METHODS as UNLOCKED
from rows import METHODS, ROWS, grazed, measured

#: In 1D they are as without.
MEAN = ("gimp, mean", "gimp, mean, affine", "finite-gimp, mean", "cpdi, mean")


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
        entry["volumetric"] = "mean"
    both = limits(entry, dimension, per_cell, steps, 0.05 if quick else 0.01)
    return {
        "method": method,
        "dimension": dimension,
        "per_cell": per_cell,
        "all": both[0],
        "best": both[1],
    }


def jobs(quick, words):
    """Every job with the key that it is kept by."""
    found = {}
    if "cases" in words:
        rows = [i for i, row in enumerate(ROWS) if not quick or row.quick is not None]
        for number in (*rows, len(ROWS)):
            known = ROWS[number].methods if number < len(ROWS) else METHODS
            label = ROWS[number].label if number < len(ROWS) else "grazing"
            found |= {("case", label, m): (case_job, number, m, quick) for m in known}
    if "courant" in words:
        for dimension in (1,) if quick else (1, 2):
            for per_cell in (1, 2, 4):
                means = MEAN if dimension > 1 else ()
                for m in (*METHODS, "gimp, affine", "finite-gimp, affine", *means):
                    key = ("courant", dimension, per_cell, m)
                    found[key] = (courant_job, m, dimension, per_cell, quick)
    if "locking" in words:
        for kind in KINDS[: 1 if quick else None]:
            for method, offset in product(UNLOCKED, OFFSETS[: 1 if quick else None]):
                found["locking", *kind, method, offset] = (locked, method, *kind, offset)
    return found
