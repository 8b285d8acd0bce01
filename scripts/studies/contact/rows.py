"""Problems of `scripts/contact`: what each line of their table measures, on two cell sizes."""

from collections.abc import Callable
from typing import Any, NamedTuple

from studies.contact import hertz, motion, problems, rolls, walls


class Row(NamedTuple):
    """A line of the table: its words, what is exact, its format, which of the numbers found."""

    words: str
    exact: str
    form: str = ".3f"
    place: int | None = None


class Problem(NamedTuple):
    """A function, its arguments on cells of one size and of half of it, and its lines."""

    function: Callable
    arguments: tuple[tuple[Any, ...], ...]
    rows: tuple[Row, ...]


def problem(function, arguments, *lines, places=None):
    """A problem; "EXACT [FORMAT]: WORDS" is a line of what it finds, or of the next number of it.

    These are in order, unless `places` says which they are.
    """
    places = places or (range(len(lines)) if len(lines) > 1 else (None,))
    rows = []
    for line, place in zip(lines, places, strict=True):
        head, words = line.split(": ", 1)
        rows.append(Row(words, *(*head.split(), ".3f")[:2], place))
    each = (one if isinstance(one, tuple) else (one,) for one in arguments)
    return Problem(function, tuple(each), tuple(rows))


def _collisions(D):
    """Blocks that meet, plain and with `affine`."""
    yield f"collision {D}", problem(
        rolls.collision, ((D, 1.0), (D, 0.5)),
        f"0 .0e: blocks of 3 and 6 cells meet with friction, {D}D: momentum that changes",
        "0 .0e: the same: angular momentum of the grid, greatest change in a step",
        "0 .0e: the same: angular momentum of the particles, in all", places=(2, 0, 1),
    )  # fmt: skip
    yield f"affine {D}", problem(rolls.collision, ((D, 1.0, True), (D, 0.5, True)),
                                 "0 .0e: the same with `affine`", places=(1,))  # fmt: skip


def _slopes(D, what, floor):
    """Wheels that roll, and that slip."""
    for name, words, angle, friction in (
        ("rolls", "that rolls, R = 5 and 10 cells", 10.0, 0.5),
        ("slips", "that slips and rolls", 30.0, 0.15),
    ):
        cells = [(D, cell, angle, friction, floor) for cell in (0.2, 0.1)]
        yield f"{name} {D}", problem(rolls.slope, cells, f"1: {what} {words}: acceleration",
                                     "1: the same: of its rotation")  # fmt: skip


PROBLEMS = {
    "tied": problem(motion.tied, (1000,),
        "0 .0e: tied bodies and one body, difference after 1,000 steps"),
    "lying": problem(motion.tied, ((1000, "unilateral"),),
        "0 .0e: the same on a wall that lets go"),
    "parting": problem(motion.parting, ((),),
        "0 .0e: a block at rest, of one that touches it and moves away: momentum taken"),
    "leaving, current": problem(motion.leaving, (("current", 0.2), ("current", 0.1)),
        "0 .0e: a ball at rest, R = 5 and 10 cells, of a plate under it that leaves, 2D and 3D: "
        "momentum taken"),
    "leaving, initial": problem(motion.leaving, (("initial", 0.2), ("initial", 0.1)),
        "0 .0e: the same in the initial configuration"),
    "bars": problem(motion.bars, (0.5, 0.25),
        "1: bars of 20 and 40 cells meet: rebound", "0: the same: energy lost"),
    "disks": problem(motion.disks, (0.04, 0.02),
        "0: Sulsky's disks, R = 5 and 10 cells: energy lost when they have parted"),
    "nairn": problem(problems.disks, (1.0, 0.5),
        "0 .4f: NairnMPM's disks, 20 mm across, R = 10 and 20 cells: energy lost (there 3.23 %)",
        places=(0,)),
    "rods": problem(problems.rods, (40, 80),
        "0 .4f: VM265's rods of 40 and 80 cells: instant at which they touch, over the time in "
        "touch", "0 .4f: the same: instant at which they part", "1: the same: rebound"),
    "ball": problem(problems.rubber_ball, (0.01, 0.005),
        "1: cases/hertz.yaml, R = 10 and 20 cells: time on the wall over Hertz's",
        "1: the same: greatest force", "0: the same: energy lost"),
    "balls": problem(hertz.balls, (0.01, 0.005),
        "1: two of these balls meet: time in touch over Hertz's", "1: the same: greatest force",
        "1: the same: radius of the circle", "1: the same: pressure in its middle",
        "0: the same: energy lost"),
    "cylinders": problem(hertz.cylinders, (4, 8),
        "1: cylinders pressed on each other, 4 and 8 cells in the half-width: it, over Hertz's",
        "1: the same: pressure in the middle",
        "1: the same: greatest pressure, over that in the middle of Hertz's"),
    **dict(_collisions(2)),
    **dict(_collisions(3)),
    "edges": problem(motion.edges, (1.0, 0.5),
        "0: they slide over each other's edges without: momentum along the faces that changes"),
    "incline": problem(motion.incline, (0.1, 0.05),
        "1: block of 10 and 20 cells on an incline of 24 degrees, friction 0.3: acceleration",
        "1: the same: heat of friction",
        "0: the same: cells by which it has sunk in, also by its weight"),
    "stuck": problem(motion.sticking, (0.1, 0.05),
        "0: friction 0.7, where it sticks: cells by which it is off a block that is tied"),
    "friction block": problem(problems.friction_block, (2.5, 1.25),
        "1: Uintah's friction block, 16 x 6 and 32 x 12 cells: acceleration",
        "1: the same: tangential over normal impulse and coefficient"),
    "corner": problem(problems.corner, (0.5, 0.25),
        "0 .0e: three blocks in a corner, of 4 and 8 cells: worst of four forces, over the weight "
        "of one",
        "0 .0e: the same: momentum that changes otherwise than by weight and walls, over the "
        "weight's"),
    "pressed": problem(problems.pressed, (1.0, 0.5),
        "1: block of 32 x 20 and 64 x 40 cells, pressed by 30 % between rigid bodies: force"),
    "bar": problem(walls.bar, (0.5, 0.25),
        "1: a bar of 20 and 40 cells hits a wall: rebound", "0: the same: energy lost"),
    "wall": problem(walls.incline, (1.0, 0.5),
        "1: block of 6 and 12 cells on a wall inclined by 24 degrees, friction 0.3: acceleration",
        "0: the same: cells by which it has sunk in, also by its weight"),
    "held": problem(walls.sticking, (1.0, 0.5),
        "0: friction 0.6, where it sticks: cells by which it is off one on a wall that holds it"),
    **dict(_slopes(2, "cylinder on a slab", "slab")),
    **dict(_slopes(3, "sphere on a rigid body", "rigid")),
    "stiff": problem(rolls.slope, [(3, h, 10.0, 0.5, "rigid", 3000.0) for h in (0.2, 0.1)],
        "1: the sphere of ten times the modulus that rolls: acceleration",
        "1: the same: of its rotation"),
}  # fmt: skip


def jobs(quick):
    """What is measured by name and cell size, 0 or 1: (function, *arguments)."""
    found = {
        (name, size): (problem.function, *arguments)
        for name, problem in PROBLEMS.items()
        for size, arguments in enumerate(problem.arguments[: 1 if quick else 2])
    }
    if quick:
        found |= {("tied", 0): (motion.tied, 100), ("lying", 0): (motion.tied, 100, "unilateral")}
    return found


def values(row, name, kept):
    """Texts of what is kept of a row, on one cell size or both."""
    found = [kept[f"{name}/{size}"] for size in (0, 1) if f"{name}/{size}" in kept]
    return [f"{v if row.place is None else v[row.place]:{row.form}}" for v in found]
