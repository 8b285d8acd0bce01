"""Problems of `scripts/contact`: what each line of their table measures, on two cell sizes."""

from collections.abc import Callable
from typing import Any, NamedTuple

from studies.contact import hertz, motion, problems, rolls, walls


class Row(NamedTuple):
    """A line of the table: its words, what is exact, which of the numbers found, and its digits."""

    words: str
    exact: str
    place: int | None = None
    form: str = "{:.3f}"


class Problem(NamedTuple):
    """A function, its arguments on cells of one size and of half of it, and its lines."""

    function: Callable
    arguments: tuple[tuple[Any, ...], ...]
    rows: tuple[Row, ...]


SMALL = "{:.0e}"


def _collisions(D):
    """Blocks that meet, plain and with `affine`."""
    same = "the same: angular momentum of the "
    yield f"collision {D}", Problem(rolls.collision, ((D, 1.0), (D, 0.5)), (
        Row(f"blocks of 3 and 6 cells meet with friction, {D}D: momentum that changes", "0", 2,
            SMALL),
        Row(f"{same}grid, greatest change in a step", "0", 0, SMALL),
        Row(f"{same}particles, in all", "0", 1, SMALL),
    ))  # fmt: skip
    yield f"affine {D}", Problem(rolls.collision, ((D, 1.0, True), (D, 0.5, True)), (
        Row("the same with `affine`", "0", 1, SMALL),
    ))  # fmt: skip


def _slopes(D, what, floor):
    """Wheels that roll, and that slip."""
    for name, words, angle, friction in (
        ("rolls", "that rolls, R = 5 and 10 cells", 10.0, 0.5),
        ("slips", "that slips and rolls", 30.0, 0.15),
    ):
        cells = tuple((D, cell, angle, friction, floor) for cell in (0.2, 0.1))
        yield f"{name} {D}", Problem(rolls.slope, cells, (
            Row(f"{what} {words}: acceleration", "1", 0),
            Row("the same: of its rotation", "1", 1),
        ))  # fmt: skip


PROBLEMS = {
    "tied": Problem(motion.tied, ((1000,),), (
        Row("tied bodies and one body, difference after 1,000 steps", "0", None, SMALL),
    )),
    "lying": Problem(motion.tied, ((1000, "separating"),), (
        Row("the same on a wall that lets go", "0", None, SMALL),
    )),
    "parting": Problem(motion.parting, ((),), (
        Row("a block at rest, of one that touches it and moves away: momentum taken", "0", None,
            SMALL),
    )),
    "leaving, current": Problem(motion.leaving, (("current", 0.2), ("current", 0.1)), (
        Row("a ball at rest, R = 5 and 10 cells, of a plate under it that leaves, 2D and 3D: "
            "momentum taken", "0", None, SMALL),
    )),
    "leaving, initial": Problem(motion.leaving, (("initial", 0.2), ("initial", 0.1)), (
        Row("the same in the initial configuration", "0", None, SMALL),
    )),
    "bars": Problem(motion.bars, ((0.5,), (0.25,)), (
        Row("bars of 20 and 40 cells meet: rebound", "1", 0),
        Row("the same: energy lost", "0", 1),
    )),
    "disks": Problem(motion.disks, ((0.04,), (0.02,)), (
        Row("Sulsky's disks, R = 5 and 10 cells: energy lost when they have parted", "0"),
    )),
    "nairn": Problem(problems.disks, ((1.0,), (0.5,)), (
        Row("NairnMPM's disks, 20 mm across, R = 10 and 20 cells: energy lost (there 3.23 %)", "0",
            0, "{:.4f}"),
    )),
    "rods": Problem(problems.rods, ((40,), (80,)), (
        Row("VM265's rods of 40 and 80 cells: instant at which they touch, over the time in touch",
            "0", 0, "{:.4f}"),
        Row("the same: instant at which they part", "0", 1, "{:.4f}"),
        Row("the same: rebound", "1", 2),
    )),
    "ball": Problem(problems.rubber_ball, ((0.01,), (0.005,)), (
        Row("cases/hertz.yaml, R = 10 and 20 cells: time on the wall over Hertz's", "1", 0),
        Row("the same: greatest force", "1", 1),
        Row("the same: energy lost", "0", 2),
    )),
    "balls": Problem(hertz.balls, ((0.01,), (0.005,)), (
        Row("two of these balls meet: time in touch over Hertz's", "1", 0),
        Row("the same: greatest force", "1", 1),
        Row("the same: radius of the circle", "1", 2),
        Row("the same: pressure in its middle", "1", 3),
        Row("the same: energy lost", "0", 4),
    )),
    "cylinders": Problem(hertz.cylinders, ((4,), (8,)), (
        Row("cylinders pressed on each other, 4 and 8 cells in the half-width: it, over Hertz's",
            "1", 0),
        Row("the same: pressure in the middle", "1", 1),
        Row("the same: greatest pressure, over that in the middle of Hertz's", "1", 2),
    )),
    **dict(_collisions(2)),
    **dict(_collisions(3)),
    "edges": Problem(motion.edges, ((1.0,), (0.5,)), (
        Row("they slide over each other's edges without: momentum along the faces that changes",
            "0"),
    )),
    "incline": Problem(motion.incline, ((0.1,), (0.05,)), (
        Row("block of 10 and 20 cells on an incline of 24 degrees, friction 0.3: acceleration", "1",
            0),
        Row("the same: heat of friction", "1", 1),
        Row("the same: cells by which it has sunk in, also by its weight", "0", 2),
    )),
    "stuck": Problem(motion.sticking, ((0.1,), (0.05,)), (
        Row("friction 0.7, where it sticks: cells by which it is off a block that is tied", "0"),
    )),
    "friction block": Problem(problems.friction_block, ((2.5,), (1.25,)), (
        Row("Uintah's friction block, 16 x 6 and 32 x 12 cells: acceleration", "1", 0),
        Row("the same: tangential over normal impulse and coefficient", "1", 1),
    )),
    "corner": Problem(problems.corner, ((0.5,), (0.25,)), (
        Row("three blocks in a corner, of 4 and 8 cells: worst of four forces, over the weight of "
            "one", "0", 0, SMALL),
        Row("the same: momentum that changes otherwise than by weight and walls, over the weight's",
            "0", 1, SMALL),
    )),
    "pressed": Problem(problems.pressed, ((1.0,), (0.5,)), (
        Row("block of 32 x 20 and 64 x 40 cells, pressed by 30 % between rigid bodies: force", "1"),
    )),
    "bar": Problem(walls.bar, ((0.5,), (0.25,)), (
        Row("a bar of 20 and 40 cells hits a wall: rebound", "1", 0),
        Row("the same: energy lost", "0", 1),
    )),
    "wall": Problem(walls.incline, ((1.0,), (0.5,)), (
        Row("block of 6 and 12 cells on a wall inclined by 24 degrees, friction 0.3: acceleration",
            "1", 0),
        Row("the same: cells by which it has sunk in, also by its weight", "0", 1),
    )),
    "held": Problem(walls.sticking, ((1.0,), (0.5,)), (
        Row("friction 0.6, where it sticks: cells by which it is off one on a wall that holds it",
            "0"),
    )),
    **dict(_slopes(2, "cylinder on a slab", "slab")),
    **dict(_slopes(3, "sphere on a rigid body", "rigid")),
    "stiff": Problem(rolls.slope, tuple((3, h, 10.0, 0.5, "rigid", 3000.0) for h in (0.2, 0.1)), (
        Row("the sphere of ten times the modulus that rolls: acceleration", "1", 0),
        Row("the same: of its rotation", "1", 1),
    )),
}  # fmt: skip


def jobs(quick):
    """What is measured by name and cell size, 0 or 1: (function, *arguments)."""
    found = {
        (name, size): (problem.function, *arguments)
        for name, problem in PROBLEMS.items()
        for size, arguments in enumerate(problem.arguments[: 1 if quick else 2])
    }
    if quick:
        found |= {("tied", 0): (motion.tied, 100), ("lying", 0): (motion.tied, 100, "separating")}
    return found


def values(row, name, kept):
    """Texts of what is kept of a row, on one cell size or both."""
    found = [kept[f"{name}/{size}"] for size in (0, 1) if f"{name}/{size}" in kept]
    return [row.form.format(v if row.place is None else v[row.place]) for v in found]
