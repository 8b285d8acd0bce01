"""Periodic domains: bodies cross seams and meet across them; layers of fluid and solids."""

from scenes import SOFT, box, scene

from rank_scenes.entries import EVERYTHING, GRID, PAIR, STIFF


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
        boundaries=dict.fromkeys(faces, "periodic") | {"y-min": "fixed", "y-max": "separating"},
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
        body["configuration"] = "initial"
    return case
