"""Measures contact against exact results and writes its tables; see scripts/contact."""

import argparse
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from datetime import date
from functools import partial
from importlib.metadata import version
from multiprocessing import get_context

from studies.contact import detection, gap, hertz, motion, problems, rolls, walls
from studies.contact.kept import Kept

from pgimp.io.rundir.runinfo import cpu

PAGES = motion.ROOT / "scripts" / "pages"
OUT = motion.ROOT / "contact.out"

#: What marks rows that were measured earlier than the others.
EARLIER = " \\*"


def _figures(quick):
    """What is measured, by name, as functions and arguments."""
    cells = (0.2,) if quick else (0.2, 0.1)
    steps = 100 if quick else 1000
    jobs = {
        ("tied",): (motion.tied, steps), ("lying",): (motion.tied, steps, "separating"),
        ("parting",): (motion.parting,),
    }  # fmt: skip
    for cell in cells:
        jobs["bars", cell] = (motion.bars, 2.5 * cell)
        jobs["disks", cell] = (motion.disks, 0.2 * cell)
        for which in ("current", "initial"):
            jobs[f"leaving, {which}", cell] = (motion.leaving, which, cell)
        jobs["edges", cell] = (motion.edges, 5.0 * cell)
        for D in (2, 3):
            jobs[f"collision {D}", cell] = (rolls.collision, D, 5.0 * cell)
            jobs[f"affine {D}", cell] = (rolls.collision, D, 5.0 * cell, True)
            floor = "slab" if D == 2 else "rigid"
            jobs[f"rolls {D}", cell] = (rolls.slope, D, cell, 10.0, 0.5, floor)
            jobs[f"slips {D}", cell] = (rolls.slope, D, cell, 30.0, 0.15, floor)
        jobs["stiff", cell] = (rolls.slope, 3, cell, 10.0, 0.5, "rigid", 3000.0)
        jobs["incline", cell] = (motion.incline, 0.5 * cell)
        jobs["stuck", cell] = (motion.sticking, 0.5 * cell)
        jobs["bar", cell] = (walls.bar, 2.5 * cell)
        jobs["wall", cell] = (walls.incline, 5.0 * cell)
        jobs["rods", cell] = (problems.rods, round(8.0 / cell))
        jobs["friction block", cell] = (problems.friction_block, 12.5 * cell)
        jobs["corner", cell] = (problems.corner, 2.5 * cell)
        jobs["nairn", cell] = (problems.disks, 5.0 * cell)
        jobs["ball", cell] = (problems.ball, 0.05 * cell)
        jobs["cylinders", cell] = (hertz.cylinders, round(0.8 / cell))
        jobs["balls", cell] = (hertz.balls, 0.05 * cell)
        jobs["pressed", cell] = (problems.pressed, 5.0 * cell)
        jobs["held", cell] = (walls.sticking, 5.0 * cell)
    return jobs


def _table(found, cells):
    """Rows of the movements."""

    def at(name, place=None, form="{:.3f}"):
        values = [found[name, cell] for cell in cells if (name, cell) in found]
        return [form.format(v if place is None else v[place]) for v in values]

    def once(name):
        return [f"{found[name,]:.0e}"] if (name,) in found else []

    rows = [
        ("tied bodies and one body, difference after 1,000 steps", "0", once("tied")),
        ("the same on a wall that lets go", "0", once("lying")),
        ("a block at rest, of one that touches it and moves away: momentum taken", "0",
         once("parting")),
        ("a ball at rest, R = 5 and 10 cells, of a plate under it that leaves, 2D and 3D: momentum "
         "taken", "0", at("leaving, current", None, "{:.0e}")),
        ("the same in the initial configuration", "0", at("leaving, initial", None, "{:.0e}")),
        ("bars of 20 and 40 cells meet: rebound", "1", at("bars", 0)),
        ("the same: energy lost", "0", at("bars", 1)),
        ("Sulsky's disks, R = 5 and 10 cells: energy lost when they have parted", "0",
         at("disks")),
        ("NairnMPM's disks, 20 mm across, R = 10 and 20 cells: energy lost (there 3.23 %)", "0",
         at("nairn", 0, "{:.4f}")),
        ("VM265's rods of 40 and 80 cells: instant at which they touch, over the time in touch",
         "0", at("rods", 0, "{:.4f}")),
        ("the same: instant at which they part", "0", at("rods", 1, "{:.4f}")),
        ("the same: rebound", "1", at("rods", 2)),
        ("cases/hertz.yaml, R = 10 and 20 cells: time on the wall over Hertz's", "1",
         at("ball", 0)),
        ("the same: greatest force", "1", at("ball", 1)),
        ("the same: energy lost", "0", at("ball", 2)),
        ("two of these balls meet: time in touch over Hertz's", "1", at("balls", 0)),
        ("the same: greatest force", "1", at("balls", 1)),
        ("the same: radius of the circle", "1", at("balls", 2)),
        ("the same: pressure in its middle", "1", at("balls", 3)),
        ("the same: energy lost", "0", at("balls", 4)),
        ("cylinders pressed on each other, 4 and 8 cells in the half-width: it, over Hertz's", "1",
         at("cylinders", 0)),
        ("the same: pressure in the middle", "1", at("cylinders", 1)),
        ("the same: greatest pressure, over that in the middle of Hertz's", "1",
         at("cylinders", 2)),
        *(row for D in (2, 3) for row in (
            (f"blocks of 3 and 6 cells meet with friction, {D}D: momentum that changes", "0",
             at(f"collision {D}", 2, "{:.0e}")),
            ("the same: angular momentum of the grid, greatest change in a step", "0",
             at(f"collision {D}", 0, "{:.0e}")),
            ("the same: angular momentum of the particles, in all", "0",
             at(f"collision {D}", 1, "{:.0e}")),
            ("the same with `affine`", "0", at(f"affine {D}", 1, "{:.0e}")),
        )),
        ("they slide over each other's edges without: momentum along the faces that changes", "0",
         at("edges")),
        ("block of 10 and 20 cells on an incline of 24 degrees, friction 0.3: acceleration", "1",
         at("incline", 0)),
        ("the same: heat of friction", "1", at("incline", 1)),
        ("the same: cells by which it has sunk in, also by its weight", "0", at("incline", 2)),
        ("friction 0.7, where it sticks: cells by which it is off a block that is tied",
         "0", at("stuck")),
        ("Uintah's friction block, 16 x 6 and 32 x 12 cells: acceleration", "1",
         at("friction block", 0)),
        ("the same: tangential over normal impulse and coefficient", "1",
         at("friction block", 1)),
        ("three blocks in a corner, of 4 and 8 cells: worst of four forces, over the weight of one",
         "0", at("corner", 0, "{:.0e}")),
        ("the same: momentum that changes otherwise than by weight and walls, over the weight's",
         "0", at("corner", 1, "{:.0e}")),
        ("block of 32 x 20 and 64 x 40 cells, pressed by 30 % between rigid bodies: force", "1",
         at("pressed")),
        ("a bar of 20 and 40 cells hits a wall: rebound", "1", at("bar", 0)),
        ("the same: energy lost", "0", at("bar", 1)),
        ("block of 6 and 12 cells on a wall inclined by 24 degrees, friction 0.3: acceleration",
         "1", at("wall", 0)),
        ("the same: cells by which it has sunk in, also by its weight", "0", at("wall", 1)),
        ("friction 0.6, where it sticks: cells by which it is off one on a wall that holds it", "0",
         at("held")),
        *(row for D, what in ((2, "cylinder on a slab"), (3, "sphere on a rigid body")) for row in (
            (f"{what} that rolls, R = 5 and 10 cells: acceleration", "1", at(f"rolls {D}", 0)),
            ("the same: of its rotation", "1", at(f"rolls {D}", 1)),
            (f"{what} that slips and rolls: acceleration", "1", at(f"slips {D}", 0)),
            ("the same: of its rotation", "1", at(f"slips {D}", 1)),
        )),
        ("the sphere of ten times the modulus that rolls: acceleration", "1", at("stiff", 0)),
        ("the same: of its rotation", "1", at("stiff", 1)),
    ]  # fmt: skip
    text = "| test | exact | measured | on half the cells |\n|---|---|---|---|\n"
    known, head = _known(), ""
    for what, exact, values in rows:
        head = head if what.startswith("the same") else what
        line = f"| {what} | {exact} | {' | '.join((*values, '', '')[:2])} |\n"
        text += line if values else known.get((head, what), "")
    return text


def _known():
    """Lines of the table that there is, by the row that they belong to and what they say.

    They are marked: it was not now that they were measured.
    """
    lines, head = {}, ""
    path = PAGES / "tables" / "contact-motion.md"
    for line in path.read_text(encoding="utf-8").splitlines()[2:] if path.exists() else ():
        if line.startswith("| ") and not line.endswith("|  |  |"):
            what, rest = line[2:].split(" | ", 1)
            what = what.removesuffix(EARLIER)
            head = head if what.startswith("the same") else what
            lines[head, what] = f"| {what}{EARLIER} | {rest}\n"
    return lines


def _gaps(rows):
    """Table of the gaps."""
    text = "| what meets | least gap | greatest |\n|---|---|---|\n"
    return text + "".join(f"| {what} | {low:.3f} | {high:.3f} |\n" for what, _, low, high in rows)


def _costs(quick, heaped):
    """Table of what contact costs; of heaps what was measured before, unless `heaped`."""
    text = "| scene | | time of a step, without contact: 1 |\n|---|---|---|\n"
    for dimensions in (2, 3):
        for apart in (True, False):
            ratio = motion.cost(apart, dimensions, 3 if quick else 9)
            where = "20 cells apart" if apart else "in touch"
            size = {2: "120 x 120 cells each, 2D", 3: "20 x 20 x 20 cells each, 3D"}[dimensions]
            text += f"| two blocks {where} | {size} | {ratio:.2f} |\n"
    for dimensions in (2, 3):
        ratio = walls.cost(dimensions, 3 if quick else 9)
        size = {2: "120 x 120 cells, 2D", 3: "20 x 20 x 20 cells, 3D"}[dimensions]
        text += f"| block on a `separating` floor, against `slip` | {size} | {ratio:.2f} |\n"
    for dimensions in (2, 3):
        ratio = walls.rigid_cost(dimensions, 3 if quick else 9)
        size = {2: "120 x 120 cells, 2D", 3: "20 x 20 x 20 cells, 3D"}[dimensions]
        text += f"| block on a rigid body as wide as it, against `slip` | {size} | {ratio:.2f} |\n"
    if not heaped:
        known = (PAGES / "tables" / "contact-costs.md").read_text(encoding="utf-8").splitlines()
        for line in known:
            what, *rest = line.split(" | ")
            if what.endswith(("into a heap", f"into a heap{EARLIER}")):
                text += " | ".join([what.removesuffix(EARLIER) + EARLIER, *rest]) + "\n"
        return text
    heaps = [("48 disks", {"steps": 800}, "2D")]
    if not quick:
        steep = {"steps": 400, "gravity": 4.0}
        heaps += [
            ("200 disks", {"count": 200, "columns": (16,)} | steep, "2D"),
            ("27 balls", {"count": 27, "columns": (3, 3), "steps": 240, "gravity": 8.0}, "3D"),
        ]
    for what, options, dimensions in heaps:
        ratio, fields = motion.heap(**(options | {"steps": 100} if quick else options))
        where = f"R = 4 cells, {dimensions}, up to {fields} velocity fields"
        text += f"| {what} that fall into a heap | {where} | {ratio:.1f} |\n"
    return text


def _show(name, future):
    """Say what has been measured, as all of it takes some time."""
    if not future.cancelled() and future.exception() is None:
        print(*name, future.result(), file=sys.stderr, flush=True)


def main():
    """Measure all, write contact.out/contact.md and, unless --quick, docs/contact.md."""
    parser = argparse.ArgumentParser(prog="scripts/contact")
    parser.add_argument("--quick", action="store_true", help="fewer and coarser; writes no page")
    parser.add_argument(
        "--only", nargs="+", metavar="NAME",
        help="these motions, 'gaps', 'detection' or 'costs', with 'heaps'; other figures stay",
    )  # fmt: skip
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count()), help="at a time")
    options = parser.parse_args()
    jobs, cells = _figures(options.quick), (0.2, 0.1)
    jobs["detection",] = (detection.text, options.quick)
    jobs["gaps", "bodies"] = (gap.rows, options.quick)
    jobs["gaps", "walls"] = (walls.gaps, options.quick)
    wanted = options.only or [*{name[0] for name in jobs}, "costs", "heaps"]
    OUT.mkdir(exist_ok=True)
    kept = Kept(OUT / ("quick.json" if options.quick else "figures.json"))
    with ProcessPoolExecutor(options.jobs, get_context("spawn")) as pool:
        waiting = {name: pool.submit(*job) for name, job in jobs.items() if name[0] in wanted}
        for name, future in waiting.items():
            future.add_done_callback(partial(_show, name))
        for name, future in waiting.items():
            kept.add(name, future.result())
    found = kept.found
    where = (
        f"Measured by `scripts/contact` on one core of {cpu()}, pgimp {version('pgimp')}, numba "
        f"{version('numba')}, {date.today()}.\n"
    )
    table = _table(found, cells)
    if EARLIER in table:
        where = where[:-1] + " Rows with \\* were measured before the last changes of contact.\n"
    texts = {"contact-motion": table + "\n" + where}
    if ("gaps", "bodies") in found and ("gaps", "walls") in found:
        texts["contact-gaps"] = _gaps([*found["gaps", "bodies"], *found["gaps", "walls"]])
    if ("detection",) in found:
        texts["contact-detection"] = found["detection",]
    if "costs" in wanted:
        texts["contact-costs"] = _costs(options.quick, "heaps" in wanted)
    (OUT / "contact.md").write_text("\n".join(texts.values()), encoding="utf-8")
    print("\n".join(texts.values()))
    if not options.quick:
        for name, text in texts.items():
            (PAGES / "tables" / f"{name}.md").write_text(text, encoding="utf-8")
        subprocess.run([sys.executable, str(PAGES)], check=True)
