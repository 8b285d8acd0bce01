"""Measures contact against exact results and writes its tables; see scripts/contact."""

import sys
from pathlib import Path

from studies.contact import detection, gap, motion, walls
from studies.contact.rows import PROBLEMS, jobs, values
from studies.harness import Kept, key, options_of, origin, out, perform, put, standing, table

#: What marks rows that were measured earlier than the others.
EARLIER = " \\*"


def _motions(kept):
    """The table of the movements.

    Lines of what is not kept are those of the table there is, marked: they were not measured now.
    """
    known, head = standing("contact-motion", EARLIER), ""
    rows = []
    for name, problem in PROBLEMS.items():
        for row in problem.rows:
            head = head if row.words.startswith("the same") else row.words
            found = values(row, name, kept)
            if found:
                rows.append((row.words, row.exact, *(*found, "", "")[:2]))
            elif any(known.get((head, row.words), ())[1:]):
                rows.append((row.words + EARLIER, *known[head, row.words]))
    return table(("test", "exact", "measured", "on half the cells"), rows)


def _gaps(rows):
    found = [(what, f"{low:.3f}", f"{high:.3f}") for what, low, high in rows]
    return table(("what meets", "least gap", "greatest"), found)


def _costs(quick, heaped):
    """Table of what contact costs; of heaps what was measured before, unless `heaped`."""
    rounds, rows = 3 if quick else 9, []
    cells = {D: " x ".join([str(count)] * D) + " cells" for D, count in motion.CELLS.items()}
    for D in (2, 3):
        for apart, where in ((True, "20 cells apart"), (False, "in touch")):
            ratio = motion.cost(apart, D, rounds)
            rows.append((f"two blocks {where}", f"{cells[D]} each, {D}D", f"{ratio:.2f}"))
    for what, cost in (
        ("block on a `unilateral` floor, against `slip`", walls.cost),
        ("block on a rigid body as wide as it, against `slip`", walls.rigid_cost),
    ):
        rows += [(what, f"{cells[D]}, {D}D", f"{cost(D, rounds):.2f}") for D in (2, 3)]
    rows += _heaps(quick) if heaped else _known_heaps()
    return table(("scene", "", "time of a step, without contact: 1"), rows)


def _heaps(quick):
    """Rows of disks and balls that fall into a heap, and of grains in a drum."""
    if not quick:
        ratio, fields = motion.drum()
        where = f"five cells across, 2D, {fields} velocity fields"
        yield "200 grains in the drum of cases/drum.yaml", where, f"{ratio:.1f}"
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
        yield f"{what} that fall into a heap", where, f"{ratio:.1f}"


def _known_heaps():
    """Those of the table that there is, marked."""
    for (_, what), rest in standing("contact-costs", EARLIER).items():
        if what.endswith(("into a heap", "drum.yaml")):
            yield what + EARLIER, *rest


def main():
    """Measure all, write contact.out/contact.md and, unless --quick, docs/contact-validation.md."""
    those = "these motions, 'gaps', 'detection' or 'costs', with 'heaps'; other figures stay"
    options = options_of(
        "contact", quick="fewer and coarser; writes no page",
        only={"nargs": "+", "metavar": "NAME", "help": those},
        jobs={"type": int, "default": 2, "help": "at a time"},
    )  # fmt: skip
    todo = jobs(options.quick) | {
        ("detection",): (detection.text, options.quick),
        ("gaps", "bodies"): (gap.rows, options.quick),
        ("gaps", "walls"): (walls.gaps, options.quick),
    }
    wanted = options.only or [*{name[0] for name in todo}, "costs", "heaps"]
    store = out("contact") / ("quick.json" if options.quick else "figures.json")
    kept = Kept(store, sources=Path(__file__).parent.glob("[!_]*.py"))
    todo = {name: job for name, job in todo.items() if name[0] in wanted}
    for name, found in perform(todo, options.jobs):
        print(key(name), found, file=sys.stderr, flush=True)
        kept.add(name, found)
    where = f"Measured by `scripts/contact` on one core of {origin()}.\n"
    motions = _motions(kept)
    if EARLIER in motions:
        where = where[:-1] + " Rows with \\* were measured before the last changes of contact.\n"
    texts = {"contact-motion": f"{motions}\n{where}"}
    if "gaps/bodies" in kept and "gaps/walls" in kept:
        texts["contact-gaps"] = _gaps([*kept["gaps/bodies"], *kept["gaps/walls"]])
    if "detection" in kept:
        texts["contact-detection"] = kept["detection"]
    if "costs" in wanted:
        texts["contact-costs"] = _costs(options.quick, "heaps" in wanted)
    print("\n".join(texts.values()))
    put(texts, out("contact") / "contact.md", not options.quick)
