"""Measures the initial configuration beside the current one; see scripts/initial."""

from itertools import product
from time import process_time

from studies.harness import Kept, key, options_of, origin, out, put, table
from studies.initial import impacts, meetings, restitution
from studies.initial.keeping import cube, hourglass, order, ringing, speed, spin, stretch, vortex

BOTH = ("current", "initial")
WHAT = ("ringing", "spin", "stretch", "vortex", "cube", "hourglass", "impact", "contact",
        "speed")  # fmt: skip
CELLS = (0.1, 0.05, 0.025)
SMOOTH = "initial, smooth"
WORDS = {
    "at rest": "block at rest on the lattice",
    "moving": "block that moves",
    "mean": "the same at rest with `volumetric: b-bar`",
    "metal": "the same of `von-mises`",
    "random": "particles at random places",
}
KINDS = tuple(WORDS)


def jobs():
    """What is measured, by name: (function, arguments)."""
    every = {}

    def add(function, *arguments, name=None):
        every[function.__name__, *(name or arguments)] = function, arguments

    for one, affine in product(BOTH, (False, True)):
        for courant in (0.3, 0.1):
            add(ringing, one, affine, courant)
        add(spin, one, affine)
    for one, D, cells in product(BOTH, (2, 3), (4, 8, 16)):
        add(cube, one, D, cells)
    for n in (1, 2):
        add(hourglass, n)
    for amplitude in (0.5, 1.0):
        for cell in CELLS:
            add(vortex, "initial", amplitude, cell)
            add(vortex, "initial", amplitude, cell, "bspline-quadratic", True,
                name=(SMOOTH, amplitude, cell))  # fmt: skip
        add(vortex, "current", amplitude, 0.05, "finite-gimp", name=("current", amplitude, 0.05))
    for shape, even in product(("gimp", "cpdi"), (True, False)):
        add(stretch, shape, even)
    for one, viscosity in product(BOTH, impacts.VISCOSITIES):
        add(impacts.impact, one, *viscosity)
    for one in BOTH:
        for name, problem in meetings.PROBLEMS.items():
            for fine in range(len(problem.arguments)):
                every["contact", one, name, fine] = meetings.meeting, (one, name, fine)
    for D, kind in product((2, 3), KINDS):
        add(speed, D, kind)
    return every


def contacts(kept):
    note = f"Measured on one core of {kept['origin']}."
    return meetings.table(lambda *name: kept.get(key(("contact", *name))), BOTH, note)


def waves(kept):
    note = f"Measured on one core of {kept['origin']}."
    return impacts.text(lambda *name: kept.get(key(("impact", *name))), note)


def text(kept):
    def of(*name):
        return kept.get(key(name)) or {}

    rows = []
    for affine in (False, True):
        words = ", affine" * affine
        for courant in (0.3, 0.1):
            left = [of("ringing", one, affine, courant).get("left", {}) for one in BOTH]
            rows.append((
                f"cantilever{words}, Courant {courant}: part of its mode's energy after 10 and 50 "
                "periods", *(", ".join(f"{part:.3f}" for part in each.values()) for each in left),
            ))  # fmt: skip
        lost = [of("spin", one, affine).get("lost") for one in BOTH]
        cells = ("" if part is None else f"{part:.1e}" for part in lost)
        rows.append((f"square{words}: part of its spin lost in 3.2 turns", *cells))
    for D in (2, 3):
        cells = []
        for one in BOTH:
            found = filter(None, (of("cube", one, D, size) for size in (4, 8, 16)))
            tips = ("stopped" if f["tip"] is None else f"{f['tip']:.3f}" for f in found)
            cells.append(", ".join(tips))
        rows.append((f"hanging cube, {D}D, 4, 8 and 16 cells: place of its tip", *cells))
    for n in (1, 2):
        found = ", ".join(f"{part:.2f}" for part in of("hourglass", n).values())
        words = "one particle a cell (refused)" if n == 1 else "two a cell and direction"
        rows.append((f"square thrown on a disk, {words}: hourglass displacements over those that "
                     "strain, after 4, 8, 12 and 16 travel times", "", found))  # fmt: skip
    for amplitude in (0.5, 1.0):
        cells = []
        for one, sizes in (("current", (0.05,)), ("initial", CELLS), (SMOOTH, CELLS)):
            found = [*filter(None, (of("vortex", one, amplitude, cell) for cell in sizes))]
            errors = [f["error"].get("0.5") for f in found]
            word = ", ".join(f"stopped at {f['stopped']:.2f}" if error is None else f"{error:.4f}"
                             for f, error in zip(found, errors, strict=True))  # fmt: skip
            if orders := [n for n in order(errors) if n]:
                word += f" (order {', '.join(f'{n:.1f}' for n in orders)})"
            cells.append(word)
        rows += [
            (f"vortex of amplitude {amplitude:g}, cells of 0.05, and of 0.1, 0.05 and 0.025: "
             "error of the displacement at t = 0.5", *cells[:2]),
            ("the same, `bspline-quadratic` with `affine`", "", cells[2]),
        ]  # fmt: skip
    for shape in ("gimp", "cpdi"):
        even, rest = of("stretch", shape, True), of("stretch", shape, False)
        if even and rest:
            rows.append(
                (
                    f"bar at five times its length, {shape}: greatest error of F, of the "
                    "force begun at rest",
                    "",
                    f"{even['F']:.0e}, {rest['force']:.3f}",
                )
            )
    for D, kind in product((2, 3), KINDS):
        if found := of("speed", D, kind):
            now, initial = found["million particle-steps/s"].values()
            rows.append(
                (
                    f"{D}D, {WORDS[kind]}: million particle-steps/s",
                    f"{now:.2f}",
                    f"{initial:.2f}: {found['ratio']:.2f} times",
                )
            )
    found = table(("", *BOTH), rows, f"Measured on one core of {kept['origin']}.")
    return found.replace("|  |", "| |")


def main():
    """Measure, and write initial.json and docs/methods.md."""
    words = {"nargs": "*", "metavar": "WHAT", "among": WHAT}
    options = options_of("initial", words=words, redraw="tables from what is there")
    kept = Kept(out("initial") / "initial.json")
    for name, (function, arguments) in ({} if options.redraw else jobs()).items():
        if name[0] not in (options.words or WHAT):
            continue
        began = process_time()
        found = function(*arguments)
        print(f"initial: {key(name)}: {found}, {process_time() - began:.0f} s", flush=True)
        kept["origin"] = origin()
        kept.add(name, found)
    model = restitution.text(f"By a model of the scheme in 1D, `scripts/initial`; {origin()}.")
    put({"initial": text(kept), "initial-contact": contacts(kept), "impacts": waves(kept),
         "restitution": model})  # fmt: skip
    print(text(kept), waves(kept), sep="\n\n")
