"""Measures the initial configuration beside the current one; see scripts/initial."""

import argparse
from time import process_time

from studies.harness import Kept, chosen, key, origin, out, put
from studies.initial import meetings
from studies.initial.keeping import cube, order, ringing, speed, spin, stretch, vortex

BOTH = ("current", "initial")
WHAT = ("ringing", "spin", "stretch", "vortex", "cube", "contact", "speed")
CELLS = (0.1, 0.05, 0.025)
SMOOTH = "initial, smooth"
WORDS = {
    "at rest": "block at rest on the lattice",
    "moving": "block that moves",
    "random": "particles at random places",
}
KINDS = tuple(WORDS)


def jobs():
    """What is measured, by name: (function, arguments)."""
    every = {}
    for one in BOTH:
        for affine in (False, True):
            for courant in (0.3, 0.1):
                every["ringing", one, affine, courant] = (ringing, (one, affine, courant))
            every["spin", one, affine] = (spin, (one, affine))
        for D, cells in ((2, 4), (2, 8), (2, 16), (3, 4), (3, 8), (3, 16)):
            every["cube", one, D, cells] = (cube, (one, D, cells))
    for amplitude in (0.5, 1.0):
        for cell in CELLS:
            every["vortex", "initial", amplitude, cell] = (vortex, ("initial", amplitude, cell))
            every["vortex", SMOOTH, amplitude, cell] = (
                vortex, ("initial", amplitude, cell, "bspline-quadratic", True)
            )  # fmt: skip
        every["vortex", "current", amplitude, 0.05] = (
            vortex, ("current", amplitude, 0.05, "finite-gimp")
        )  # fmt: skip
    for shape in ("gimp", "cpdi"):
        for even in (True, False):
            every["stretch", shape, even] = (stretch, (shape, even))
    for one in BOTH:
        for name, problem in meetings.PROBLEMS.items():
            for fine in range(len(problem.arguments)):
                every["contact", one, name, fine] = (meetings.meeting, (one, name, fine))
    for D in (2, 3):
        for kind in KINDS:
            every["speed", D, kind] = (speed, (D, kind))
    return every


def contacts(kept):
    note = f"Measured on one core of {kept['origin']}."
    return meetings.table(lambda *name: kept.get(key(("contact", *name))), BOTH, note)


def text(kept):
    def of(*name):
        return kept.get(key(name))

    lines = ["| | current | initial |", "|---|---|---|"]
    for affine in (False, True):
        words = ", affine" * affine
        for courant in (0.3, 0.1):
            cells = []
            for one in BOTH:
                found = of("ringing", one, affine, courant)
                left = found["left"] if found else {}
                cells.append(", ".join(f"{left[n]:.3f}" for n in left))
            lines.append(
                f"| cantilever{words}, Courant {courant}: part of its mode's energy after 10 and "
                f"50 periods | {' | '.join(cells)} |"
            )
        cells = [f"{found['lost']:.1e}" if (found := of("spin", one, affine)) else ""
                 for one in BOTH]  # fmt: skip
        lines.append(f"| square{words}: part of its spin lost in 3.2 turns | {' | '.join(cells)} |")
    for D in (2, 3):
        cells = []
        for one in BOTH:
            found = [of("cube", one, D, cells) for cells in (4, 8, 16)]
            cells.append(", ".join("stopped" if f["tip"] is None else f"{f['tip']:.3f}"
                                   for f in found if f))  # fmt: skip
        lines.append(f"| hanging cube, {D}D, 4, 8 and 16 cells: place of its tip | "
                     f"{' | '.join(cells)} |")  # fmt: skip
    for amplitude in (0.5, 1.0):
        cells = []
        for one, sizes in (("current", (0.05,)), ("initial", CELLS), (SMOOTH, CELLS)):
            found = [of("vortex", one, amplitude, cell) for cell in sizes]
            found = [f for f in found if f]
            word = ", ".join(f"{f['error']['0.5']:.4f}" if "0.5" in f["error"]
                             else f"stopped at {f['stopped']:.2f}" for f in found)  # fmt: skip
            errors = [f["error"].get("0.5") for f in found]
            orders = [n for n in order(errors) if n]
            if orders:
                word += f" (order {', '.join(f'{n:.1f}' for n in orders)})"
            cells.append(word)
        lines += [
            f"| vortex of amplitude {amplitude:g}, cells of 0.05, and of 0.1, 0.05 and 0.025: "
            f"error of the displacement at t = 0.5 | {' | '.join(cells[:2])} |",
            f"| the same, `bspline-quadratic` with `affine` | | {cells[2]} |",
        ]
    for shape in ("gimp", "cpdi"):
        found = of("stretch", shape, True), of("stretch", shape, False)
        if all(found):
            lines.append(f"| bar at five times its length, {shape}: greatest error of F, of the "
                         f"force begun at rest | | {found[0]['F']:.0e}, "
                         f"{found[1]['force']:.3f} |")  # fmt: skip
    for D in (2, 3):
        for kind in KINDS:
            if found := of("speed", D, kind):
                each = found["million particle-steps/s"]
                lines.append(f"| {D}D, {WORDS[kind]}: million particle-steps/s | "
                             f"{each['current']:.2f} | {each['initial']:.2f}: "
                             f"{found['ratio']:.2f} times |")  # fmt: skip
    return "\n".join([*lines, "", f"Measured on one core of {kept['origin']}.", ""])


def main():
    """Measure, and write initial.json and docs/methods.md."""
    parser = argparse.ArgumentParser(prog="scripts/initial")
    parser.add_argument("words", nargs="*", metavar="WHAT", help=", ".join(WHAT))
    parser.add_argument("--redraw", action="store_true", help="tables from what is there")
    options = parser.parse_args()
    words = chosen(parser, options.words, WHAT) or WHAT
    kept = Kept(out("initial") / "initial.json")
    for name, (function, arguments) in ({} if options.redraw else jobs()).items():
        if name[0] not in words:
            continue
        began = process_time()
        found = function(*arguments)
        print(f"initial: {key(name)}: {found}, {process_time() - began:.0f} s", flush=True)
        kept["origin"] = origin()
        kept.add(name, found)
    put({"initial": text(kept), "initial-contact": contacts(kept)})
    print(text(kept))
