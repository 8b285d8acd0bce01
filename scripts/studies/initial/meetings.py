"""Bodies that meet in either configuration: problems of scripts/contact."""

from contextlib import contextmanager
from pathlib import Path

from studies.contact import motion, problems, rolls, walls

import pgimp

#: What is measured by name: its words, what is exact, and what of the result; the function and its
#: arguments on cells of one size, and of half of it.
PROBLEMS = {
    "bars": (
        (("bars of 20 and 40 cells meet: rebound", "1", 0),),
        motion.bars, ((0.5,), (0.25,)),
    ),
    "sulsky": (
        (("Sulsky's disks, R = 5 and 10 cells: energy lost when they have parted", "0", 0),),
        motion.disks, ((0.04,), (0.02,)),
    ),
    "nairn": (
        (("NairnMPM's disks, R = 10 and 20 cells: energy lost", "0", 0),),
        problems.disks, ((1.0,), (0.5,)),
    ),
    "ball": (
        (("cases/hertz.yaml, R = 10 and 20 cells: time on the wall over Hertz's", "1", 0),
         ("the same: greatest force", "1", 1), ("the same: energy lost", "0", 2)),
        problems.ball, ((0.01,), (0.005,)),
    ),
    "rods": (
        (("VM265's rods of 40 and 80 cells: instant at which they touch, over the time in touch",
          "0", 0), ("the same: instant at which they part", "0", 1), ("the same: rebound", "1", 2)),
        problems.rods, ((40,), (80,)),
    ),
    "friction block": (
        (("Uintah's friction block, 16 x 6 and 32 x 12 cells: acceleration", "1", 0),
         ("the same: tangential over normal impulse and coefficient", "1", 1)),
        problems.friction_block, ((2.5,), (1.25,)),
    ),
    "incline": (
        (("block of 10 and 20 cells on an incline of 24 degrees, friction 0.3: acceleration", "1",
          0), ("the same: heat of friction", "1", 1)),
        motion.incline, ((0.1,), (0.05,)),
    ),
    "corner": (
        (("three blocks in a corner, of 4 and 8 cells: worst of four forces, over the weight of "
          "one", "0", 0),
         ("the same: momentum that changes otherwise than by weight and walls, over the weight's",
          "0", 1)),
        problems.corner, ((0.5,), (0.25,)),
    ),
    "wall": (
        (("block of 6 and 12 cells on a wall inclined by 24 degrees, friction 0.3: acceleration",
          "1", 0),),
        walls.incline, ((1.0,), (0.5,)),
    ),
    "rolls": (
        (("cylinder on a slab that rolls, R = 5 and 10 cells: acceleration", "1", 0),
         ("the same: of its rotation", "1", 1)),
        rolls.slope, ((2, 0.2, 10.0, 0.5, "slab"), (2, 0.1, 10.0, 0.5, "slab")),
    ),
    "slips": (
        (("cylinder on a slab that slips and rolls: acceleration", "1", 0),
         ("the same: of its rotation", "1", 1)),
        rolls.slope, ((2, 0.2, 30.0, 0.15, "slab"), (2, 0.1, 30.0, 0.15, "slab")),
    ),
    "sphere rolls": (
        (("sphere on a rigid body that rolls, R = 5 and 10 cells: acceleration", "1", 0),
         ("the same: of its rotation", "1", 1)),
        rolls.slope, ((3, 0.2, 10.0, 0.5, "rigid"), (3, 0.1, 10.0, 0.5, "rigid")),
    ),
    "sphere slips": (
        (("sphere on a rigid body that slips and rolls: acceleration", "1", 0),
         ("the same: of its rotation", "1", 1)),
        rolls.slope, ((3, 0.2, 30.0, 0.15, "rigid"), (3, 0.1, 30.0, 0.15, "rigid")),
    ),
    "pressed": (
        (("block of 32 x 20 and 64 x 40 cells, pressed by 30 % between rigid bodies: force", "1",
          None),),
        problems.pressed, ((1.0,), (0.5,)),
    ),
    "cost 2": (
        (("two blocks of 120 x 120 cells in touch, time of a step over that without contact", "",
          None),),
        motion.cost, ((False, 2, 9),),
    ),
    "cost 3": (
        (("two blocks of 20 x 20 x 20 cells in touch, time of a step over that without contact",
          "", None),),
        motion.cost, ((False, 3, 9),),
    ),
    "rigid cost": (
        (("block of 20 x 20 x 20 cells on a rigid body, time of a step over that on a `slip` wall",
          "", None),),
        walls.rigid_cost, ((3, 9),),
    ),
}  # fmt: skip


@contextmanager
def _configured(configuration):
    """Let all bodies of a material be in a configuration."""
    plain = pgimp.Simulation

    def begin(case, overrides=()):
        if isinstance(case, Path):
            of = pgimp.load(case).bodies
            changes = {f"bodies.{name}.configuration": configuration for name in of}
            return plain(case, overrides=dict(overrides) | changes)
        for body in case["bodies"].values():
            if "material" in body:
                body["configuration"] = configuration
        return plain(case, overrides=overrides)

    pgimp.Simulation = begin
    try:
        yield
    finally:
        pgimp.Simulation = plain


def meeting(configuration, name, fine):
    """What a problem finds, on cells of one size or of half of it; a list of numbers."""
    _, function, arguments = PROBLEMS[name]
    with _configured(configuration):
        found = function(*arguments[fine])
    return [float(number) for number in (found if isinstance(found, tuple) else (found,))]


def table(of, configurations):
    """The table of docs/contact.md; `of` gives what is kept of (configuration, name, fine)."""
    heads = [text for one in configurations for text in (one, f"{one}, on half the cells")]
    lines = ["| test | exact | " + " | ".join(heads) + " |", "|---" * (2 + len(heads)) + "|"]
    for name, (rows, _, _) in PROBLEMS.items():
        for words, exact, place in rows:
            cells = []
            for one in configurations:
                for fine in (0, 1):
                    found = of(one, name, fine)
                    value = None if found is None else found[place or 0]
                    text = "" if value is None else f"{value:.3f}"
                    if value is not None and abs(value) < 1e-3:
                        text = f"{value:.0e}"
                    cells.append(text)
            lines.append(f"| {words} | {exact} | {' | '.join(cells)} |")
    return "\n".join(lines)
