"""Bodies that meet by their surfaces in periodic domains: nothing depends on where a seam is."""

from itertools import product

import numpy as np
import pytest
from scenes import box, energy, finish, scene, start
from tiers import wide

from pgimp.errors import CaseError
from pgimp.kernels.contact.surfaces.nearest import FLAT

pytestmark = pytest.mark.slow(60)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}


def placed(low, high, shift, sides):
    """A box that is moved by `shift` in a periodic domain; sides of 0 have no period."""
    parts = [[]]
    for a, b, way, side in zip(low, high, shift, sides, strict=True):
        a, b = a + way, b + way
        turn = np.floor(a / side) * side if side else 0.0
        a, b = a - turn, b - turn
        ends = [(a, b)] if not side or b <= side else [(a, side), (0.0, b - side)]
        parts = [[*part, end] for part, end in product(parts, ends)]
    boxes = [{"box": {"min": [a for a, _ in part], "max": [b for _, b in part]}} for part in parts]
    return boxes[0] if len(boxes) == 1 else {"union": boxes}


def periodic(axes):
    return {f"{'xyz'[d]}-{end}": "periodic" for d in axes for end in ("min", "max")}


def run(case):
    sim = start(case)
    return sim.diagnostics(), finish(sim).diagnostics()


def sliding(shift, floor, around=True):
    """A block with friction on a floor: a body, a rigid one, a wall; it passes the seam or not."""
    side, low = 12.0, 0.0625 if floor == "wall" else 2.0625
    region = placed([4.25, low], [8.4375, low + 2.5], [shift, 0.0], [side * around, 0.0])
    block = {"material": "soft", "region": region, "velocity": [2.0, -1.0]}
    bodies, faces = {"block": block | EXACT}, periodic((0,)) if around else {}
    if floor == "wall":
        faces["y-min"] = {"unilateral": {"friction": 0.3}}
    elif floor == "rigid":
        ends = ([-1.0, -1.0], [side + 1.0, 2.0])
        bodies["floor"] = {"rigid": {}, "region": {"box": {"min": ends[0], "max": ends[1]}}}
    else:
        region = {"box": {"min": [0.0, 0.0], "max": [side, 2.0]}}
        bodies["floor"] = {"material": "soft", "region": region} | EXACT
        faces["y-min"] = "fixed"
    return scene(2, bodies, cells=[12, 7], step=0.02, end=1.5, gravity=[0.0, -1.0],
                 boundaries=faces, contact=[{"bodies": "all", "friction": 0.3}]
                 if floor != "wall" else [])  # fmt: skip


def require_same(one, other, rel=1e-9):
    """The same lines, but for what has coordinates in it."""
    places = ("centre", "angular", "displacement", "torque")
    names = [name for name in one if name in other and not any(part in name for part in places)]
    size = max(abs(one[name]) for name in names)
    for name in names:
        assert abs(one[name] - other[name]) < rel * size, name


@pytest.mark.parametrize("floor", ["rigid", wide("wall"), wide("body")])
def test_a_block_does_not_feel_where_a_seam_is(floor):
    """Beside it, cut by it, passing it; and where there is none, on what has an end."""
    one = run(sliding(0.0, floor))[1]
    assert one["body.block.momentum-x"] < 15.0  # friction has slowed it
    for shift in (6.0, 3.0):
        require_same(one, run(sliding(shift, floor))[1])
    if floor != "body":  # a soft one without ends is another one
        require_same(one, run(sliding(0.0, floor, False))[1])


def corners(D, shift, free=False):
    """Two blocks whose corners meet, askew, with friction, in a domain without ends."""
    cells = [12, 11] if D == 2 else [11, 8, 8]
    blocks = {"a": ([2.125, 2.25, 2.0], [5.3125, 5.125, 4.25], [3.0, 1.0, 0.5]),
              "b": ([6.375, 2.875, 2.3125], [9.1875, 6.25, 4.75], [-2.0, -0.5, 0.0])}  # fmt: skip
    if D == 3:
        blocks = {name: (low, [a - 0.6875 for a in high], v)
                  for name, (low, high, v) in blocks.items()}  # fmt: skip
    bodies = {
        name: {"material": "soft", "velocity": v[:D],
               "region": placed(low[:D], high[:D], shift, cells)} | EXACT
        for name, (low, high, v) in blocks.items()
    }  # fmt: skip
    if free:
        centre = [5.375 + shift[0], 8.125 + shift[1]]
        bodies["puck"] = {"rigid": {"density": 2.0}, "velocity": [-1.0, -3.0],
                          "region": {"ball": {"centre": centre, "radius": 1.25}}}  # fmt: skip
    return scene(D, bodies, cells=cells, step=0.02, end=1.5, boundaries=periodic(range(D)),
                 contact=[{"bodies": "all", "friction": 0.3}])  # fmt: skip


@pytest.mark.parametrize(
    ("D", "shift", "free"),
    [(2, (7, 5), False), (2, (7, 3), True), wide(2, (0, 7), False), wide(3, (6, 4, 4), False)],
)
def test_corners_meet_across_seams_as_elsewhere(D, shift, free):
    """Momentum is that of before to rounding."""
    lines = [run(corners(D, where, free)) for where in ((0,) * D, shift)]
    for first, last in lines:
        for axis in "xyz"[:D]:
            parts = [
                sum(
                    line.get(name, 0.0)
                    for name in (f"momentum-{axis}", f"rigid.puck.momentum-{axis}")
                )
                for line in (first, last)
            ]
            assert abs(parts[1] - parts[0]) < 1e-12 * first["mass"]
        assert energy(last) < energy(first) or free
        assert last["contact.all.normal-impulse"] > 1.0
    require_same(lines[0][1], lines[1][1], 1e-6 if free else 1e-9)


@pytest.mark.wide
def test_a_pile_across_a_seam_rests():
    """As one beside it, on a wall with friction."""
    g, lines = 0.5, []
    for shift, side in ((0.0, 0.0), (5.0, 12.0)):
        bodies = {}
        for k in range(3):
            low = [4.25 + 0.125 * k, 3.0 * k]
            region = placed(low, [low[0] + 4.0, low[1] + 3.0], [shift, 0.0], [side, 0.0])
            bodies[f"b{k}"] = {"material": "soft", "region": region} | EXACT
        weight = {"table": [[0.0, [0.0, 0.0]], [5.0, [0.0, -g]]]}
        faces = {"y-min": {"unilateral": {"friction": 0.3}}} | periodic((0,) if side else ())
        lines.append(run(
            scene(2, bodies, cells=[12, 10], step=0.02, end=12.0, gravity=weight, boundaries=faces,
                  contact=[{"bodies": "all", "friction": 0.3}], damping={"mass": 2.0})
        )[1])  # fmt: skip
    assert lines[1]["kinetic-energy"] < 1e-3 * lines[1]["strain-energy"]
    require_same(*lines, 1e-7)


def test_a_free_body_is_no_longer_than_a_period():
    """One with a prescribed motion that does not turn may be."""
    case = sliding(0.0, "rigid")
    case["bodies"]["floor"]["rigid"] = {"density": 1.0, "fixed": ["rotation"]}
    with pytest.raises(CaseError, match="its images come too near each other"):
        start(case)
    case["bodies"]["floor"]["rigid"] = {"rotation": {"about": [6.0, 0.0], "rate": 1.0}}
    with pytest.raises(CaseError, match="as it turns"):
        start(case)


def test_ends_that_differ_at_a_seam_are_surfaces():
    """A block that slides over a seam against the side of a plateau which ends there rebounds."""
    steps = [{"box": {"min": [0.0, 0.0], "max": [12.0, 2.0]}},
             {"box": {"min": [8.1, 0.0], "max": [12.0, 4.1]}}]  # fmt: skip
    block = {"box": {"min": [1.2, 2.2], "max": [3.7, 3.7]}}
    bodies = {
        "floor": {"material": "soft", "region": {"union": steps}} | EXACT,
        "block": {"material": "soft", "region": block, "velocity": [-2.0, 0.0]} | EXACT,
    }
    case = scene(2, bodies, cells=[12, 7], step=0.02, end=1.5, contact=[{"bodies": "all"}],
                 boundaries=periodic((0,)) | {"y-min": "fixed"})  # fmt: skip
    first, last = run(case)
    assert last["body.block.momentum-x"] > -0.3 * first["body.block.momentum-x"] > 0.0


def test_facets_beside_a_seam_are_not_said_to_be_in_a_plane():
    """What follows neighbours across a seam looks for images; elsewhere a face is flat."""
    bodies = {"strip": box([0.0, 1.2], [12.0, 3.4]) | EXACT,
              "block": box([4.1, 3.5], [7.2, 5.3]) | EXACT}  # fmt: skip
    sim = start(scene(2, bodies, cells=[12, 8], step=0.01, end=0.1, contact=[{"bodies": "all"}],
                      boundaries={"x-min": "periodic", "x-max": "periodic"}))  # fmt: skip
    sim.advance()
    surface = sim.rank.contact.known(sim.rank).surface
    top = (surface.body == 0) & (surface.normal[:, 1] > 0.99)
    x = surface.x[top, 0] % 12.0
    away = np.minimum(x, 12.0 - x)
    flat = surface.tip[top] & FLAT != 0
    assert (away < 0.2).any()
    assert not flat[away < 0.2].any()
    assert flat[away > 0.5].all()
