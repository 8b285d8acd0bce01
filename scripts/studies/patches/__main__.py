"""Measures contact of bodies by their own surfaces against exact results; see scripts/patches."""

from studies.harness import Kept, options_of, origin, out, put, table
from studies.patches import edges, fast, hard, impacts, pressed, slopes, speed

OFFSETS = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.0), (0.13, 0.21), (0.37, 0.78))
STILL, FRAMES = (0.0, 0.0), ((0.0, 0.0), (0.02, 0.0), (0.05, 0.02), (0.2, 0.05))
LATTICES = ((0.37, 0.21), (0.2, 0.6), (0.97, 0.02))
SIDES = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.0), (0.13, 0.21), (-0.13, 0.21))
PRESSED = ((0.13, 0.21), (0.5, 0.5), (0.33, 0.77), (0.8, 0.6))
WHAT = ("bars", "disks", "oblique", "blocks", "hertz", "slopes", "beam", "hard", "speed")


def spread(values):
    """Least and greatest of some numbers."""
    return f"{min(values):.4f} to {max(values):.4f}"


def bars():
    for n in (20, 40, 80):
        found = [impacts.bars(n, STILL, at) for at in OFFSETS[:4]]
        rebounds = [each["restitution"] for each in found]
        moving = [impacts.bars(n, V, OFFSETS[3])["restitution"] for V in FRAMES]
        averaged = [impacts.bars(n, V, OFFSETS[3], mass="averaged") for V in FRAMES[::3]]
        most = max(each["most"] for each in found + averaged)
        yield (f"bars of {n} cells, at four places in the cell: rebound", "1", spread(rebounds))
        yield ("the same, all moving at 0 to .2 of the speed of waves: spread", "0",
               f"{max(moving) - min(moving):.0e}")  # fmt: skip
        yield ("the same, averaged mass, moving at 0 and .2: rebound", "1",
               spread([each["restitution"] for each in averaged]))  # fmt: skip
        yield ("all these: greatest energy over the first", "1", f"{most:.6f}")


def disks():
    for R in (5, 10, 20):
        found = [impacts.disks(R, STILL, (*at, 0.0, 0.0)) for at in OFFSETS]
        rebounds = [each["restitution"] for each in found]
        moving = [impacts.disks(R, V, (*OFFSETS[3], 0.0, 0.0))["restitution"] for V in FRAMES]
        yield (f"disks, R = {R} cells, at five places in the cell: rebound", ".985",
               spread(rebounds))  # fmt: skip
        yield ("the same, all moving at 0 to .2 of the speed of waves: spread", "0",
               f"{max(moving) - min(moving):.0e}")  # fmt: skip
        yield ("the same: momentum and angular momentum that change; greatest energy", "0, 1",
               f"{max(max(each['momentum'], each['spin']) for each in found):.0e}, "
               f"{max(each['most'] for each in found):.6f}")  # fmt: skip


def oblique():
    for R in (5, 10, 20):
        found = [slopes.oblique(R, at) for at in SIDES[: 5 if R < 20 else 2]]
        yield (f"a disk, R = {R} cells, slips at 60 degrees: spin", ".975",
               spread([each["spin"] for each in found]))  # fmt: skip


def blocks():
    for D, ways in ((2, LATTICES), (3, LATTICES[1:2])):
        for angle in (0, 17, 45):
            found = [pressed.patch_test(D, way, angle) for way in ways]
            least, most, rms = (f([each[n] for each in found]) for n, f in
                                enumerate((min, max, max)))  # fmt: skip
            yield (
                f"blocks whose lattices differ, turned by {angle} degrees, {D}D: stress of all "
                "particles, and rms of its error",
                "1",
                f"{least:.3f} to {most:.3f}, {rms:.4f}",
            )


def hertz():
    words = "greatest pressure of a patch over Hertz's, and recovered"
    for R in (16, 32):
        found = [pressed.line(R, at) for at in PRESSED]
        greatest, recovered = ([each[n] for each in found] for n in ("greatest", "recovered"))
        yield (f"disk pressed on a plane, {found[0]['half width']:.1f} cells in the half-width, at "
               f"four places in the cell: {words}", "1",
               f"{spread(greatest)}, {spread(recovered)}")  # fmt: skip
    one = pressed.sphere()
    yield (f"ball, in 3D, pressed on a plane, {one['half width']:.1f} cells in the half-width: "
           f"{words}", "1", f"{one['greatest']:.3f}, {one['recovered']:.3f}")  # fmt: skip


def rolling():
    for R in (8, 16):
        for words, *how in (("rolls", 25.0, 0.3), ("slips", 50.0, 0.25)):
            a, spin = slopes.slope(R, *how)
            yield (f"a disk, R = {R} cells, {words}: acceleration, and of its rotation", "1",
                   f"{a:.4f}, {spin:.4f}")  # fmt: skip


def beam():
    found = [edges.beam(edge) for edge in (0.44, 0.4425, 0.445, 0.4475)]
    yield ("a beam on the edge of a rigid block, at four places in the cell: deflection", "1",
           spread([each[0] for each in found]))  # fmt: skip
    yield ("the same: sideways over vertical force", "0", f"{max(each[1] for each in found):.0e}")
    yield ("a round plate on a rigid ring, at four places in the cell: deflection", "1",
           spread([edges.plate(edge) for edge in (38.0, 38.25, 38.5, 38.75)]))  # fmt: skip


def scenes():
    """Hard scenes; greatest depth in cells, and what becomes of the energy."""
    slid = hard.over_the_edge()
    yield ("a block slides over the edge of a table: depth, cells", "0", f"{slid['depth']:.4f}")
    for angle in (20.0, 30.0, 60.0, 90.0):
        found = [hard.wedge(angle, order) for order in (("wedge", "block"), ("block", "wedge"))]
        words = "; ".join(f"{one['depth']:.3f}, {one['most']:.3f}" for one in found)
        yield (f"a wedge of {angle:g} degrees hits a block, either first: depth, cells, and "
               "greatest energy", "0, 1", words)  # fmt: skip
    for shape in ("disk", "square"):
        one = fast.fast(shape=shape)
        yield (f"{shape}s meet at .3 of the speed of waves: depth, cells, and energy left", "0",
               f"{one['depth']:.3f}, {one['energy']:.3f}")  # fmt: skip
    for thick in (1.0, 2.0):
        found = hard.plates(thick)
        yield (f"plates {thick:g} cells thick meet flat, askew, edge on: depth, cells", "0",
               ", ".join(f"{one['depth']:.4f}" for one in found.values()))  # fmt: skip
    one = hard.cube_on_its_corner()
    yield ("a cube stands on its corner on a rigid floor, in 3D: depth, cells, and force over "
           "weight", "0, 1", f"{one['depth']:.3f}, {one['force over weight']:.4f}")  # fmt: skip
    one = hard.peg()
    yield ("a peg pushed askew through a slot: depth, cells", "0", f"{one['depth']:.4f}")
    one = hard.pile()
    first, last = one["kinetic over strain, first half of rest, second"]
    yield ("a pile of ten blocks, 100,000 steps: depth, and drift to the side, cells", "0",
           f"{one['depth']:.0e}, {one['drift x']:.0e}")  # fmt: skip
    yield ("the same: kinetic over strain energy in the third and the last quarter", "",
           f"{first:.4f}, {last:.4f}")  # fmt: skip


def speeds():
    for words, *how in (
        ("a block on a floor", "floor", (15, 10, 10)),
        ("a block on a rigid body", "rigid", (20, 20, 20)),
        ("a block on another", "two", (15, 10, 10)),
    ):
        one = speed.speed(*how)
        yield (f"{words}, {one['particles']:,} particles: time of a step over one in free fall, "
               "million particle-steps/s, sweeps", "",
               f"{one['ratio']:.2f}, {one['million']:.1f}, {one['sweeps']:.0f}")  # fmt: skip
    one = speed.bounce()
    yield ("`block3d` while it is squashed on its floor: time of a step over one in free fall, "
           "million particle-steps/s", "", f"{one['ratio']:.2f}, {one['million']:.1f}")  # fmt: skip


FUNCTIONS = dict(zip(WHAT, (bars, disks, oblique, blocks, hertz, rolling, beam, scenes, speeds),
                     strict=True))  # fmt: skip


def main():
    """Measure, and write the table of docs/contact-validation.md."""
    words = {"nargs": "*", "metavar": "WHAT", "among": WHAT}
    options = options_of("patches", words=words)
    kept = Kept(out("patches") / "patches.json")
    for name in options.words or WHAT:
        kept.add(name, list(FUNCTIONS[name]()))
        kept["origin"] = origin()
        for row in kept[name]:
            print(*row, sep=" | ", flush=True)
    if not all(kept.get(name) for name in WHAT[:-1]):
        return  # the page has all of them; the times of steps, where they have been measured
    rows = [row for name in WHAT for row in kept.get(name) or ()]
    note = f"Measured by `scripts/patches` on one core of {kept['origin']}."
    put({"surface-contact": table(("test", "exact", "measured"), rows, note)})


if __name__ == "__main__":
    main()
