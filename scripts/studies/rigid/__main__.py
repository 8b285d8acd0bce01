"""Measures rigid bodies that meet each other, against exact results; see scripts/rigid."""

from studies.harness import options_of, origin, put, table
from studies.rigid import scenes


def rows():
    for e in (0.5, 0.8, 1.0):
        tops, off = scenes.bounces(e)
        yield (f"box falls on a floor, e = {e:g}: heights of bounces",
               ", ".join(f"{e ** (2 * k):.3g}" for k in range(1, 1 + len(tops))),
               ", ".join(f"{top:.3f}" for top in tops))  # fmt: skip
        yield ("the same: greatest energy", "1", f"{1.0 + off:.4f}")
    for first in (1, 2):
        v, energy = scenes.cradle(first)
        yield (f"cradle of five balls, e = 1, {first} of them hit the others: velocities, energy",
               ", ".join("1" if k >= 5 - first else "0" for k in range(5)) + ", 1",
               ", ".join(f"{abs(x):.4f}" for x in (*v, energy)))  # fmt: skip
    for radius in (3.0, 5.0, 10.0):
        off = scenes.oblique(radius)
        yield (f"balls, R = {radius:g} cells, e = .8, mu = .1 and .6, meet at 40 degrees: error of "
               "velocity, of spin", "0", f"{off[0]:.3f}, {off[1]:.3f}")  # fmt: skip
    for friction in (0.0, 0.5):
        drift, motion = scenes.stack(friction)
        yield (f"stack of five boxes, mu = {friction:g}, 10 s: drift, cells; kinetic energy", "0",
               f"{drift:.0e}, {motion:.0e}")  # fmt: skip
    for friction in (0.1, 0.4, 0.5):
        way, exact = scenes.incline(friction)
        yield (f"box on an incline of 25 degrees, mu = {friction:g}: way", f"{exact:.3f}",
               f"{way:.3f}")  # fmt: skip
    for wide in (4.0, 8.0):
        quarter, peak = scenes.rocking(wide)
        yield (f"block, {wide:g} cells wide, rocks: quarter of a period, next angle, over "
               "Housner's", "1", f"{quarter:.3f}, {peak:.3f}")  # fmt: skip
    for clearance in (0.1, 1.0):
        for friction in (0.0, 0.5):
            deep, books = scenes.peg(clearance, friction)
            yield (f"peg pushed askew at a hole, clearance {clearance:g} cells, mu = {friction:g}: "
                   "depth, cells; energy that balances miss", "0",
                   f"{deep:.3f}, {books:.4f}")  # fmt: skip
    force, way = scenes.pressed()
    yield ("rigid block pressed on an elastic one: force, way", "1", f"{force:.3f}, {way:.3f}")
    found = [scenes.corner(3, 1.0), scenes.corner(2, 1.0)]
    yield ("cube, and square, stand on a corner: depth when they stand, cells", "0",
           ", ".join(f"{one:.3f}" for one in found))  # fmt: skip


def main():
    """Measure, and write the table of docs/contact-validation.md."""
    options_of("rigid")
    found = []
    for row in rows():
        found.append(row)
        print(*row, sep=" | ", flush=True)
    note = f"Measured by `scripts/rigid` on one core of {origin()}."
    put({"rigid-contact": table(("test", "exact", "measured"), found, note)})


if __name__ == "__main__":
    main()
