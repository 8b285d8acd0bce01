"""Scenes in plane stress: plates that meet, flow, and reach a face that absorbs."""

from scenes import SOFT, box, scene

from rank_scenes.entries import EVERYTHING, STIFF

METAL = {
    "model": "von-mises", "young": 200.0, "poisson": 0.3, "density": 1.0, "yield-stress": 2.0,
    "hardening": 10.0,
}  # fmt: skip


def _plates(bodies, **parts):
    """Plates of three laws, under gravity, seen in all that can be seen."""
    case = scene(
        2, bodies, cells=[18, 8], shape="gimp", end=1.0, step={"courant": 0.3},
        materials={"soft": SOFT, "stiff": STIFF | {"model": "hooke"}, "metal": METAL},
        gravity=[0.0, -1.0], history={"every": {"steps": 10}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": ["mass", "force"]}, **parts,
    )  # fmt: skip
    case["geometry"], case["method"]["affine"] = "plane-stress", True
    return case


def plates():
    """A plate of metal flies into one that is pulled, past a stamp; one is at an absorbing face."""
    bodies = {
        "flier": box([1.0, 2.0], [4.2, 4.9], [4.0, 0.5], "metal"),
        "pulled": box([6.0, 1.1], [11.0, 6.0]),
        "ground": box([12.5, 0.0], [18.0, 2.3], None, "stiff"),
        "stamp": {
            "rigid": {"velocity": [0.0, -1.0]},
            "region": {"ball": {"center": [14.0, 5.2], "radius": 2.5}},
        },
    }
    return _plates(
        bodies,
        boundaries={"y-min": "slip", "x-max": {"absorbing": {"held": "fixed"}}},
        contact=[{"bodies": "all", "friction": 0.3}],
        tractions={"pull": {"body": "pulled", "face": "y-max", "traction": [0.5, 6.0]}},
        probes={"rim": {"body": "pulled", "at": [6.5, 5.0]}},
    )


def plates_initial():
    """The same laws in the initial configuration, where two meet; one is pulled from a wall."""
    bodies = {
        "flier": box([1.0, 2.0], [4.2, 4.9], [4.0, 0.5], "metal"),
        "held": box([5.0, 0.0], [10.0, 6.0]),
        "other": box([11.1, 1.3], [16.8, 3.3], [-2.0, 1.0], "stiff"),
    }
    for body in bodies.values():
        body["formulation"] = "total-lagrangian"
    return _plates(
        bodies,
        boundaries={"y-min": "fixed"},
        tractions={
            "wind": {
                "body": "other", "traction": [0.3, -0.2], "follower": False,
                "region": {"ball": {"center": [16.8, 2.3], "radius": 1.5}},
            }
        },
        contact=[{"bodies": "all", "friction": 0.3}],
        constraints={
            "grip": {
                "body": "held", "region": {"half-space": {"point": [0, 5.4], "normal": [0, -1]}},
                "force": [None, 8.0], "mass": 3.0, "spring": {"stiffness": 5.0, "dashpot": 1.0},
            }
        },
    )  # fmt: skip
