"""Bodies that come in stages, beside those that fly, go, and are of another configuration."""

from scenes import box, scene

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
            "rests": box([16.0, 5.0], [18.0, 7.0], [-0.5, 0.0]) | {"configuration": "initial"},
        },
        cells=[20, 10],
        shape="gimp",
        gravity=[0.0, -0.5],
        boundaries={"x-max": "slip", "y-min": {"separating": {"friction": 0.2}}},
        escape={"x-min": "remove"},
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
