"""Bodies that meet in either configuration: problems of scripts/contact."""

from contextlib import contextmanager
from pathlib import Path

from studies import harness
from studies.contact import motion, rows, walls
from studies.contact.rows import Problem, Row

import pgimp

#: Problems of scripts/contact by the names of their figures, and how many of their lines.
SHOWN = {
    "bars": ("bars", 1), "sulsky": ("disks", 1), "nairn": ("nairn", 1), "ball": ("ball", 3),
    "rods": ("rods", 3), "friction block": ("friction block", 2), "incline": ("incline", 2),
    "corner": ("corner", 2), "wall": ("wall", 1), "rolls": ("rolls 2", 2), "slips": ("slips 2", 2),
    "sphere rolls": ("rolls 3", 2), "sphere slips": ("slips 3", 2), "pressed": ("pressed", 1),
}  # fmt: skip
#: What a line says that is shorter here.
SHORTER = {"nairn": "NairnMPM's disks, R = 10 and 20 cells: energy lost"}


def _cost(function, arguments, words):
    return Problem(function, (arguments,), (Row(words, ""),))


PROBLEMS = {
    name: rows.PROBLEMS[there]._replace(rows=rows.PROBLEMS[there].rows[:count])
    for name, (there, count) in SHOWN.items()
} | {
    "cost 2": _cost(motion.cost, (False, 2, 9), "two blocks of 120 x 120 cells in touch, time of a "
                    "step over that without contact"),
    "cost 3": _cost(motion.cost, (False, 3, 9), "two blocks of 20 x 20 x 20 cells in touch, time "
                    "of a step over that without contact"),
    "rigid cost": _cost(walls.rigid_cost, (3, 9), "block of 20 x 20 x 20 cells on a rigid body, "
                        "time of a step over that on a `slip` wall"),
}  # fmt: skip


@contextmanager
def _configured(configuration):
    """Let all bodies of a material be in a configuration."""
    plain = pgimp.Simulation

    def begin(case, overrides=()):
        if isinstance(case, Path):
            of = pgimp.load(case).bodies
            changes = {f"bodies.{name}.formulation": configuration for name in of}
            return plain(case, overrides=dict(overrides) | changes)
        for body in case["bodies"].values():
            if "material" in body:
                body["formulation"] = configuration
        return plain(case, overrides=overrides)

    pgimp.Simulation = begin
    try:
        yield
    finally:
        pgimp.Simulation = plain


def meeting(configuration, name, fine):
    """What a problem finds, on cells of one size or of half of it; a list of numbers."""
    problem = PROBLEMS[name]
    with _configured(configuration):
        found = problem.function(*problem.arguments[fine])
    return [float(number) for number in (found if isinstance(found, tuple) else (found,))]


def table(of, configurations, note):
    """The table of bodies that meet; `of` gives a (configuration, name, fine)."""
    heads = [text for one in configurations for text in (one, f"{one}, on half the cells")]
    lines = []
    for name, problem in PROBLEMS.items():
        for row in problem.rows:
            found = [of(one, name, fine) for one in configurations for fine in (0, 1)]
            values = [None if each is None else each[row.place or 0] for each in found]
            cells = [
                "" if value is None else f"{value:{'.0e' if abs(value) < 1e-3 else '.3f'}}"
                for value in values
            ]
            lines.append((SHORTER.get(name, row.words), row.exact, *cells))
    return harness.table(("test", "exact", *heads), lines, note)
