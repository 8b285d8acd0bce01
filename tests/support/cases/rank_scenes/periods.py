"""Periodic domains: bodies cross seams and meet across them; layers of fluid and solids."""

from scenes import SOFT, box, scene

from pgimp.physics.columns import SURFACE
from rank_scenes.entries import EVERYTHING, GRID, PAIR, STIFF
from rank_scenes.initial_bodies import within


def round_and_round():
    """Periodic along x and y; bodies meet across both seams, some are loaded, another is held."""
    bodies = {
        "quick": box([0.0, 6.0], [2.0, 8.0], [-9.0, 4.0]),
        "slow": box([12.0, 5.0], [14.0, 7.0], [3.0, -5.0], "stiff"),
        "held": box([5.0, 1.0], [8.0, 3.0]),
    }
    return scene(
        2,
        bodies,
        cells=[16, 8],
        end=1.2,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[2.0, -1.0],
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min", "y-max"), "periodic"),
        contact=[{"bodies": "all", "friction": 0.3}],
        tractions={
            "wind": {"body": "slow", "face": "x-min", "pressure": 2.0},
            "pull": {
                "body": "quick", "pressure": -4.0,
                "region": {"half-space": {"point": [1.2, 0.0], "normal": [1.0, 0.0]}},
            },
        },
        constraints={
            "grip": {"body": "held", "region": {"box": {"min": [5, 1], "max": [6, 3]}},
                     "velocity": [4.0, None]}
        },
        output={"every": 0.3, "fields": [*EVERYTHING, "unwrapped"], "grid": [*GRID, "contact"]},
        history={"every": {"steps": 10}},
        probes={
            "tip": {"body": "quick", "at": [0.0, 7.0]},
            "seam": {"place": [0.1, 7.9], "every": {"steps": 4}},
        },
    )  # fmt: skip


def rigid_round():
    """Rigid bodies cross seams, one moves freely; a block and a bar of fluid meet them there."""
    fluid = {"model": "newtonian", "bulk": 100.0, "shear-viscosity": 0.5, "density": 1.0}
    wheel = {"velocity": [5.0, -1.0], "rotation": {"about": [15.0, 6.0], "rate": 4.0}}
    bodies = {
        "block": box([1.0, 1.0], [4.0, 4.0], [-6.0, 2.0]),
        "bar": box([8.0, 8.0], [12.0, 10.0], [4.0, -8.0], "fluid"),
        "wheel": {"rigid": wheel, "region": {"ball": {"centre": [15.0, 6.0], "radius": 1.5}}},
        "stone": {
            "rigid": {"density": 1.5},
            "region": {"box": {"min": [15.0, 1.0], "max": [17.0, 3.0]}},
            "velocity": [3.0, 0.5],
        },
    }
    return scene(
        2,
        bodies,
        cells=[16, 12],
        end=1.2,
        step={"courant": 0.3},
        materials={"soft": SOFT, "fluid": fluid},
        gravity=[2.0, -1.0],
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min", "y-max"), "periodic"),
        contact=[{"bodies": "all", "friction": 0.3}],
        output={"every": 0.3, "fields": [*EVERYTHING, "unwrapped"], "grid": [*GRID, "contact"]},
        history={"every": {"steps": 10}},
    )


def layer():
    """A layer of fluid from seam to seam flows down a channel that is periodic along x and z."""
    fluid = {"model": "newtonian", "bulk": 100.0, "shear-viscosity": 2.0, "density": 1.0}
    faces = ("x-min", "x-max", "z-min", "z-max")
    return scene(
        3,
        box([0.0] * 3, [9.0, 3.0, 4.0], [8.0, 0.0, 1.0]),
        cells=[9, 5, 4],
        shape="finite-gimp",
        end=0.6,
        step=0.012,
        materials={"soft": fluid},
        gravity=[3.0, -5.0, 0.5],
        boundaries=dict.fromkeys(faces, "periodic") | {"y-min": "fixed", "y-max": "unilateral"},
        output={"every": 0.2, "fields": EVERYTHING, "grid": ["mass"]},
        history={"every": {"steps": 10}},
        probes={"bottom": {"place": [0.0, 1.0, 0.0]}},
    )


def endless():
    """A soft and a stiff layer in the initial configuration, sheared along a periodic x and y."""
    bodies = {
        "lower": box([0.0, 0.0], [13.0, 2.0], [6.0, -1.0]),
        "upper": box([0.0, 2.0], [13.0, 4.0], [-2.0, 1.0], "stiff"),
    }
    case = scene(
        2,
        bodies,
        cells=[13, 6],
        end=1.0,
        step={"courant": 0.3},
        materials={"soft": SOFT, "stiff": STIFF},
        gravity=[1.0, -0.5],
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min", "y-max"), "periodic"),
        output={"every": 0.25, "fields": [*EVERYTHING, "unwrapped"], "grid": ["mass", "velocity"]},
        history={"every": {"steps": 10}},
        probes={"top": {"body": "upper", "at": [0.0, 4.0]}},
    )
    for body in bodies.values():
        body["formulation"] = "total-lagrangian"
    return case


def surface_round():
    """Bodies meet through and beside seams: soft, rigid and free ones, and a plate from end to end.

    One is bonded to another across a seam, until a stage ends that.
    """
    balls = [{"ball": {"centre": [x, y], "radius": 1.9}} for x in (0.3, 18.3) for y in (0.4, 11.4)]
    bars = [
        {"box": {"min": [low, 4.02], "max": [high, 5.97]}} for low, high in ((0, 2.6), (13.9, 18))
    ]
    ends = [18.0, 11.0]
    bodies = {
        "bar": {"material": "soft", "region": within(ends, *bars), "velocity": [0.0, -1.0]},
        "disk": {"material": "stiff", "region": within(ends, *balls), "velocity": [2.0, 1.5],
                 "mass": "averaged"},
        "glued": box([2.6, 4.02], [5.03, 5.97], [0.0, -1.0]),
        "flies": box([9.2, 8.1], [11.7, 10.3], [7.0, 1.0], "stiff"),
    }  # fmt: skip
    bodies = {
        name: body | {"formulation": "total-lagrangian", "surface": "exact"}
        for name, body in bodies.items()
    }
    plate = {"box": {"min": [-2.0, 6.7], "max": [20.0, 7.9]}}
    bodies["plate"] = {"rigid": {"velocity": [3.0, -0.7]}, "region": plate}
    bodies["puck"] = {"rigid": {"density": 2.0}, "velocity": [-3.0, 2.0],
                      "region": {"ball": {"center": [8.2, 2.2], "radius": 1.2}}}  # fmt: skip
    faces = ("x-min", "x-max", "y-min", "y-max")
    case = scene(
        2,
        bodies,
        cells=[18, 11],
        shape="finite-gimp",
        end=0.6,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries=dict.fromkeys(faces, "periodic"),
        contact=[{"bodies": "all", "friction": 0.3}, {"bodies": ["bar", "glued"], "law": "tie"}],
        output={"every": 0.3, "fields": [*EVERYTHING, "unwrapped"], "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [
        {"name": "loose", "end": 1.2, "contact": [{"bodies": "all", "friction": 0.3}]}
    ]
    return case


def mixed_round():
    """A current bed from end to end, and blocks of both kinds on it, through and beside seams.

    A stage removes one of these. Frames have the loads of surfaces.
    """
    balls = [{"ball": {"centre": [x, 4.1], "radius": 1.9}} for x in (0.3, 18.3)]
    initial = {"formulation": "total-lagrangian"}
    bodies = {
        "bed": box([0.0, 0.0], [18.0, 2.1]),
        "disk": {"material": "stiff", "region": within([18.0, 11.0], *balls),
                 "velocity": [2.0, -2.5]} | initial,
        "slides": box([4.2, 2.15], [6.7, 4.3], [-4.0, -1.0]) | initial,
        "falls": box([13.4, 2.2], [15.8, 4.35], [4.0, -1.0], "stiff"),
        "goes": box([8.3, 2.12], [10.1, 4.0]) | initial,
        "puck": {"rigid": {"density": 2.0}, "velocity": [2.0, -3.0],
                 "region": {"ball": {"center": [11.2, 4.3], "radius": 1.2}}},
        "plate": {"rigid": {"velocity": [3.0, -0.7]},
                  "region": {"box": {"min": [-2.0, 6.2], "max": [20.0, 7.4]}}},
    }  # fmt: skip
    case = scene(
        2,
        bodies,
        cells=[18, 9],
        shape="finite-gimp",
        end=0.5,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"x-min": "periodic", "x-max": "periodic", "y-min": "unilateral"},
        contact=[{"bodies": "all", "friction": 0.3}],
        output={"every": 0.2, "fields": [*EVERYTHING, "unwrapped"], "surface": [*SURFACE]},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [{"name": "later", "end": 1.0, "remove": ["goes"]}]
    return case


def mixed_flows():
    """Water and sand in a tank with rough walls that let go; gates, which are initial, in them.

    These meet each other at vertices, with friction; gradients are carried, and cells have means.
    """
    initial = {"formulation": "total-lagrangian"}
    water = {"model": "newtonian", "bulk": 200.0, "density": 1.0, "shear-viscosity": 1e-3}
    sand = SOFT | {"model": "drucker-prager", "cohesion": 0.0, "friction-angle": 30.0,
                   "dilation-angle": 0.0}  # fmt: skip
    bodies = {
        "water": box([0.0, 0.0], [4.0, 4.6], None, "water"),
        "sand": box([4.0, 0.0], [7.6, 3.0], [1.0, 0.0], "sand"),
        "gate": box([7.7, 0.4], [9.2, 4.4], None, "stiff") | initial,
        "stone": box([10.3, 0.0], [12.6, 2.2], [-3.0, 0.0]),
        "lid": box([4.4, 3.2], [6.7, 4.7], [0.0, -2.0], "stiff") | initial,
    }
    faces = {"x-min": "slip", "y-min": {"separating": {"friction": 0.3}},
             "x-max": {"separating": {"friction": 0.1}}}  # fmt: skip
    case = scene(
        2,
        bodies,
        cells=[15, 7],
        end=0.7,
        step={"courant": 0.3},
        materials=PAIR | {"water": water, "sand": sand},
        gravity=[0.0, -1.0],
        boundaries=faces,
        contact=[{"bodies": "all", "friction": 0.3}],
        output={"every": 0.35, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )
    case["method"] |= {"affine": True, "volumetric": "b-bar"}
    return case
