"""Bodies that come in stages, beside those that fly, go, and are of another configuration."""

from scenes import SOFT, box, scene

from rank_scenes.entries import EVERYTHING

#: A disk that comes from above, whose surface cuts particles.
DISK = {"ball": {"centre": [11.2, 6.7], "radius": 1.6}}


def lifts():
    """Two bodies come at once, one in the place of another that goes, and later a third one.

    The second stage begins between two re-sorts. A traction and a constraint wait for their body.
    """
    case = scene(
        2,
        {
            "flies": box([2.0, 2.0], [5.0, 5.0], [2.0, 0.3]),
            "goes": box([9.0, 1.0], [12.0, 4.0]),
            "lift": {"material": "stiff", "region": DISK, "velocity": [-0.5, -1.5]},
            "new": box([9.5, 1.0], [12.0, 3.5], [0.0, 1.0], "stiff"),
            "last": box([14.0, 2.0], [17.0, 4.0], [-2.0, 0.0]),
            "rests": box([16.0, 5.0], [18.0, 7.0], [-0.5, 0.0])
            | {"formulation": "total-lagrangian"},
        },
        cells=[20, 10],
        shape="gimp",
        gravity=[0.0, -0.5],
        boundaries={"x-max": "slip", "y-min": {"unilateral": {"friction": 0.2}}},
        outflow={"x-min": "remove"},
        tractions={"push": {"body": "new", "face": "x-max", "pressure": 0.5}},
        constraints={
            "grip": {"body": "last", "region": {"box": {"min": [16.0, 2.0], "max": [17.0, 4.0]}},
                     "velocity": [-1.0, None]},
        },
        contact=[{"bodies": "all", "friction": 0.2}],
        output={"every": 0.25, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
        probes={"flies": {"body": "flies", "at": [3.0, 3.0]}},
        step={"courant": 0.3},
        end=0.4,
    )  # fmt: skip
    case["materials"]["stiff"] = case["materials"]["soft"] | {"young": 200.0, "density": 2.0}
    case["time"]["stages"] = [
        {"name": "fill", "end": 0.7, "add": ["lift", "new"], "remove": ["goes"], "step": 0.01},
        {
            "name": "more", "end": 1.0, "add": ["last"], "step": {"courant": 0.25},
            "materials": {"soft": {"young": 60.0}},
        },
    ]  # fmt: skip
    return case


def streams():
    """A jet meets sand that pours across several slabs, over a beam; both leave, one ends.

    The jet becomes faster; a stage with steps of another kind begins while both enter.
    """
    water = {"model": "newtonian", "bulk": 80.0, "shear-viscosity": 0.2, "density": 1.0}
    sand = {
        "model": "drucker-prager", "young": 100.0, "poisson": 0.3, "density": 1.0,
        "cohesion": 0.0, "friction-angle": 30.0, "dilation-angle": 5.0,
    }  # fmt: skip
    case = scene(
        2,
        {
            "jet": box([12.0, 5.0], [14.0, 6.0], [4.0, 0.0], "water"),
            "sand": box([5.0, 8.0], [13.0, 10.0], material="sand"),
            "beam": box([4.0, 2.0], [9.0, 3.0]) | {"formulation": "total-lagrangian"},
        },
        cells=[20, 10],
        gravity=[0.0, -2.0],
        materials={"soft": SOFT, "water": water, "sand": sand},
        boundaries={"y-min": "unilateral"},
        constraints={
            "clamp": {"body": "beam", "region": {"box": {"min": [4.0, 2.0], "max": [5.0, 3.0]}},
                      "velocity": [0.0, 0.0]},
        },
        inflow={
            "sand": {"velocity": [0.0, -3.0], "until": 0.75},
            "jet": {"velocity": [{"ramp": {"from": 4.0, "to": 7.0, "duration": 0.8}}, 0.0]},
        },
        outflow={"x-max": "remove", "x-min": "remove"},
        contact=[{"bodies": "all", "friction": 0.2}],
        output={"every": 0.25, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
        step={"courant": 0.25},
        end=0.5,
    )  # fmt: skip
    case["method"]["affine"] = True
    case["time"]["stages"] = [{"name": "faster", "end": 1.0, "step": 0.0078125}]
    return case


def pours():
    """Material enters beside a seam across which it spreads, and from below."""
    return scene(
        2,
        {
            "pours": box([12.0, 7.0], [16.0, 9.0]),
            "rises": box([7.0, 1.0], [13.0, 2.0]),
            "drifts": box([0.0, 4.0], [2.0, 6.0], [6.0, 0.0]),
        },
        cells=[16, 10],
        boundaries={"x-min": "periodic", "x-max": "periodic"},
        inflow={"pours": {"velocity": [0.0, -5.0]}, "rises": {"velocity": [0.0, 3.0]}},
        outflow={"y-min": "remove", "y-max": "remove"},
        output={"every": 0.25, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
        step={"courant": 0.3},
        end=1.0,
        gravity=[3.0, 0.0],
        shape="finite-gimp",
    )
