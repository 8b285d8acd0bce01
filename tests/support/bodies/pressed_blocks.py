"""Blocks and disks on rigid plates, which meet by their surfaces, with frames of these."""

from scenes import SOFT, box, scene

from pgimp.physics.columns import SURFACE

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}
HARD = SOFT | {"young": 1000.0}


def on_a_plate(body, plate, cells, end, every, **parts):
    """A body of the hard solid on a rigid plate; frames and lines of the history at one time.

    `plate` is corners, and velocity.
    """
    low, high, velocity = plate
    bodies = {
        "block": {"material": "soft"} | body | EXACT,
        "plate": {"rigid": {"velocity": velocity}, "region": box(low, high)["region"]},
    }
    parts = {"damping": {"mass": 2.0}, "gravity": [0.0, -10.0], "friction": 0.0} | parts
    contact = [{"bodies": ["block", "plate"], "friction": parts.pop("friction")}]
    return scene(
        len(low),
        bodies,
        cells=cells,
        end=end,
        step={"courant": 0.3},
        materials={"soft": HARD},
        contact=contact,
        output={"every": every, "surface": [*SURFACE]},
        history={"every": every},
        **parts,
    )


def resting_block(edge=11.3, end=8.0):
    """A block at rest, 6 wide and 2 high, on a plate that ends at `edge`; the block at 9.3."""
    block = box([3.3, 3.0], [9.3, 5.0])
    plate = [1.0, 1.0], [edge, 3.0], [0.0, 0.0]
    return on_a_plate(block, plate, [14, 8], end, 0.5 * end, damping={"mass": 6.0})


def sliding_block(end=1.0):
    """A block that slides on a plate which moves the other way."""
    block = box([7.3, 3.0], [13.3, 5.0], [3.0, 0.0])
    plate = [1.0, 1.0], [24.0, 3.0], [-1.0, 0.0]
    return on_a_plate(block, plate, [26, 8], end, 0.25 * end, friction=0.2)


def pressed_disk(R, end, load):
    """A disk under its weight, of which `load` is the gravity, damped; it touches the plate."""
    centre, rate = [R + 4.13, R + 4.21], 33.0 / R
    disk = {"region": {"ball": {"centre": centre, "radius": R}}}
    floor = centre[1] - R - 1e-3
    plate = [1.3, floor - 3.0], [2.0 * R + 7.7, floor], [0.0, 0.0]
    gravity = {"table": [[0.0, [0.0, 0.0]], [12.0 / rate, [0.0, -load]]]}
    cells = [int(2.0 * R + 9.0), int(2.0 * R + 8.0)]
    end /= rate
    damping = {"mass": 0.5 * rate}
    return on_a_plate(disk, plate, cells, end, end / 8.0, gravity=gravity, damping=damping)
