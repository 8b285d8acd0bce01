"""Measures waves with lumped and with averaged mass; see scripts/waves."""

import numpy as np
from studies.harness import options_of, origin, put, table
from studies.waves import bars, bodies, costs, dispersion, impacts, lasting, standing

MASSES = ("lumped", "averaged")


def _percent(value):
    return f"{100.0 * value:.2g}"


def speeds():
    """Rows of errors of plane waves, by dimensions and cells a wave."""
    for D, cells in ((1, 6), (1, 10), (1, 16), (2, 6), (2, 10), (2, 16), (3, 6), (3, 10), (3, 16)):
        errors = dispersion.Errors("gimp", D, 2, (cells,))
        parts = 0.0, dispersion.part("gimp", D, 2, 0.3)
        found = [np.sqrt((errors(alpha, 0.3) ** 2).mean(axis=0)) for alpha in parts]
        shear = [_percent(np.sqrt((each[:-1] ** 2).mean())) if D > 1 else "" for each in found]
        pressure = [_percent(each[-1]) for each in found]
        yield [f"{D}D", cells, *pressure, *shear]


def main():
    """Measure what is asked for, and print its tables."""
    names = "numbers", "speeds", "pulse", "bodies", "standing", "impacts", "costs", "long"
    what = {"nargs": "*", "among": names, "metavar": "WHAT"}
    steps, docs = {"type": int, "default": 100_000}, "write the tables of costs into the pages"
    options = options_of("waves", what=what, steps=steps, docs=docs)
    chosen = options.what or names[1:-1]
    measured = f"Measured by `scripts/waves` on one core of {origin()}."
    if "numbers" in chosen:
        for shape in ("gimp", "bspline-quadratic", "fuzzy-nearest", "fuzzy-constant"):
            for D in (1, 2, 3):
                found = {n: dispersion.best(shape, D, n) for n in (1, 2, 3, 4)[: 4 - (D == 3)]}
                print(shape, D, {n: tuple(np.round(each, 3)) for n, each in found.items()})
    if "speeds" in chosen:
        titles = ["", "cells a wave", "P, lumped", "averaged", "S, lumped", "averaged"]
        print(table(titles, speeds(), measured))
    if "pulse" in chosen:
        print(table(["mass", "error after 10 lengths", "height"], bars.rows(), measured))
        titles = ["mass", "front, cells from 0.9 to 0.1", "overshoot"]
        print(table(titles, bars.front_rows(), measured))
    if "bodies" in chosen:
        titles = ["first 12 modes, rms [%]", *(f"{a}, {b}" for a, b in bodies.WAYS),
                  "highest over lumped, boxes", "cut"]  # fmt: skip
        print(table(titles, bodies.rows(), measured))
    if "standing" in chosen:
        print(table(["wave", "lumped", "averaged"], standing.rows(), measured))
    if "impacts" in chosen:
        titles = ["bars", "Courant", "speed left, lumped", "averaged", "energy lost, lumped",
                  "averaged"]  # fmt: skip
        print(table(titles, impacts.rows(), measured))
    if "long" in chosen:
        titles = ["scene", "Courant", "mass", "energy", "its drift", "spin", "momentum"]
        print(table(titles, lasting.rows(options.steps), measured))
    if "costs" in chosen:
        titles = ["mass", "cells a wave", "particles", "error of P, S waves [%]", "CPU seconds",
                  "over lumped"]  # fmt: skip
        found = {"waves-cost": table(titles, costs.waves(), measured)}
        titles = ["", "particles", "million particle-steps/s", "speed over the other's"]
        found["initial-costs"] = table(titles, costs.steps(), measured)
        print("\n".join(found.values()))
        if options.docs:
            put(found)
