"""Scenes of problems with known answers that no case of cases/ has, without a method."""

from studies.flow.sand import LOOSE, ROUGH
from studies.method.timoshenko import slowest

#: Load of the elastica, P L^2/(E I) = 2, on the end of a beam of 8 x 0.5.
ELASTICA = 2.0 * 1000.0 * 0.5**3 / 12.0 / 64.0 / 0.5
#: Angular frequencies of the beam, and of water 0.5 deep in a tank of length 1.
BEAM, SLOSHING = slowest(8.0, 1.0)[0], (9.81 * 3.14159265 * 0.917152) ** 0.5


def box(low, high):
    """A region that is a box."""
    return {"box": {"min": low, "max": high}}


def ball(centre, radius):
    """A region that is a ball."""
    return {"ball": {"centre": centre, "radius": radius}}


def _scene(size, cell, end, material, bodies, every, **more):
    """A case of one material, `solid`, but for what `more` has."""
    return {
        "format": 1, "dimensions": len(size), "grid": {"size": size, "cell": [cell] * len(size)},
        "time": {"end": end}, "materials": {"solid": material}, "bodies": bodies,
        "history": {"every": every}, **more,
    }  # fmt: skip


def _body(region):
    return {"material": "solid", "region": region}


def _elastic(young, poisson=0.0):
    return {"model": "neo-hookean", "young": young, "poisson": poisson, "density": 1.0}


_CLAY = {"model": "von-mises", "young": 1000.0, "poisson": 0.3, "density": 1.0,
         "yield-stress": 3.0**0.5}  # fmt: skip
_WATER = {"model": "newtonian", "bulk": 4.9e5, "density": 1000.0, "shear-viscosity": 1.0e-3}
_TANK = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}

#: A cantilever that a dead load bends by half its length.
BENT = _scene(
    [10.0, 7.0], 0.125, 60.0, _elastic(1000.0), {"beam": _body(box([0.0, 5.0], [9.0, 5.5]))}, 1.0,
    title="Elastica", damping={"mass": 0.5},
    constraints={"clamp": {"body": "beam", "region": box([0.0, 4.0], [1.0, 6.0]),
                           "velocity": [0.0, 0.0]}},
    tractions={"load": {"body": "beam", "region": box([8.99, 4.0], [9.1, 6.0]), "follower": False,
                        "traction": {"table": [[0.0, [0.0, 0.0]], [20.0, [0.0, -ELASTICA]]]}}},
    probes={"tip": {"body": "beam", "at": [9.0, 5.25], "every": 1.0}},
)  # fmt: skip
#: A square bar whose end turns by 0.1, free to warp, three sides long.
TWISTED = _scene(
    [4.0, 2.0, 2.0], 0.25, 3.0, _elastic(2600.0, 0.3),
    {"bar": _body(box([0.0, 0.5, 0.5], [4.0, 1.5, 1.5]))}, 0.05, title="Torsion",
    damping={"mass": 4.0},
    constraints={
        name: {
            "body": "bar", "region": box([x, 0.0, 0.0], [x + 0.5, 2.0, 2.0]),
            "velocity": [None, 0.0, 0.0],
            "rotation": {"about": [0.0, 1.0, 1.0], "axis": [1.0, 0.0, 0.0],
                         "rate": {"table": [[0.0, rate], [1.0, rate], [1.001, 0.0]]}},
        }
        for name, x, rate in (("rests", 0.0, 0.0), ("turns", 3.5, 0.1))
    },
)  # fmt: skip
#: A cantilever that its weight, at once, lets vibrate.
SWINGING = _scene(
    [9.0, 3.0], 0.25, 5.0 * 6.2831853 / BEAM, _elastic(1.0),
    {"beam": _body(box([0.0, 1.0], [8.0, 2.0]))}, 2.0, title="A beam's frequency",
    boundaries={"x-min": "fixed"}, gravity=[0.0, -1.0e-5],
)  # fmt: skip
#: A quarter of a disk between two rigid plates.
CRUSHED = _scene(
    [1.3, 1.2], 0.1, 4.0, _elastic(1000.0, 0.3),
    {
        "disk": _body({"intersection": [ball([0.0, 0.0], 1.0), box([0.0, 0.0], [1.0, 1.0])]}),
        "plate": {
            "rigid": {"velocity": {"table": [[0.0, [0.0, 0.0]], [1.0, [0.0, -0.01]]]}},
            "region": box([-1.0, 1.0], [1.3, 1.2]),
        },
    },
    0.05, title="Brazilian disk", damping={"mass": 3.0}, boundaries={"x-min": "slip",
                                                                    "y-min": "slip"},
    probes={"middle": {"body": "disk", "at": [0.025, 0.025], "every": 0.05}},
)  # fmt: skip
#: Half a thick sphere with a pressure inside, as rings.
SPHERE = _scene(
    [2.2, 2.2], 0.1, 2.0, _elastic(1000.0, 0.3),
    {"sphere": _body({"difference": [
        {"intersection": [ball([0.0, 0.0], 2.0), box([0.0, 0.0], [2.0, 2.0])]},
        ball([0.0, 0.0], 1.0),
    ]})}, 0.05,
    title="Thick sphere", geometry="axisymmetric", boundaries={"y-min": "slip"},
    tractions={"inside": {"body": "sphere", "region": ball([0.0, 0.0], 1.2),
                          "pressure": {"table": [[0.0, 0.0], [1.0, 5.0]]}}},
    probes={"half": {"body": "sphere", "at": [1.5, 0.05], "every": 0.05}},
)  # fmt: skip
#: Water that swings about the level that a weak pull to one side gives it.
SLOSHES = _scene(
    [1.0, 0.7], 0.05, 5.0, _WATER, {"water": _body(box([0.0, 0.0], [1.0, 0.5]))}, 0.01,
    title="Sloshing", boundaries=_TANK, start={"stress": {"k0": 1.0}},
    gravity={"table": [[0.0, [0.0, -9.81]], [0.1, [1.0, -9.81]]]},
)  # fmt: skip
#: A block of half the density of the water in which it lies a fifth too high.
FLOATS = _scene(
    [1.0, 0.8], 0.04, 3.0, _WATER,
    {
        "water": _body({"difference": [box([0.0, 0.0], [1.0, 0.48]),
                                       box([0.32, 0.4], [0.68, 0.8])]}),
        "block": {"material": "wood", "region": box([0.32, 0.4], [0.68, 0.6])},
    },
    0.02, title="A block floats", boundaries=_TANK, gravity=[0.0, -9.81], damping={"mass": 3.0},
    materials={"solid": _WATER, "wood": {"model": "neo-hookean", "young": 1.0e6, "poisson": 0.3,
                                         "density": 500.0}},
)  # fmt: skip
#: Clay without friction before a smooth wall, which moves in by a hundredth of its height.
PUSHED = _scene(
    [6.0, 1.4], 0.1, 4.0, _CLAY,
    {
        "clay": _body(box([1.0, 0.0], [6.0, 1.0])),
        "wall": {
            "rigid": {"velocity": {"table": [[0.0, [0.0, 0.0]], [0.5, [0.015, 0.0]]]}},
            "region": box([0.0, -1.0], [1.0, 1.4]),
        },
    },
    0.02, title="Passive wall", boundaries={"y-min": "slip", "x-max": "slip"},
    gravity={"table": [[0.0, [0.0, 0.0]], [0.3, [0.0, -1.0]]]},
)  # fmt: skip


def _sand(ratio):
    """Half a column of dry sand, `ratio` times as high as wide, on a rough floor."""
    return _scene(
        [2.2 + 1.6 * ratio, ratio + 0.2], 0.05, 6.0 * (ratio / 9.81) ** 0.5,
        LOOSE | {"young": 1.0e6 * ratio}, {"column": _body(box([0.0, 0.0], [1.0, ratio]))}, 0.1,
        title="Heap", boundaries={"x-min": "slip", "x-max": "slip", "y-min": ROUGH},
        gravity=[0.0, -9.81],
    )  # fmt: skip


HEAP, TALL = _sand(1.0), _sand(3.0)
