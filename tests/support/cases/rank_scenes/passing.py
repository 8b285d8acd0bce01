"""Loads on surfaces whose size along a line moves, in both configurations and in stages."""

from scenes import box, scene

from rank_scenes.entries import EVERYTHING, GRID, PAIR


def passing():
    """A wheel rolls over a block, a front of pressure passes a disk, beside a load that rests.

    Both pass slabs. The wheel goes to and fro; a stage lets it go on faster, and another begins it
    anew from elsewhere. The front stays behind itself.
    """
    wheel = {
        "along": [1.0, 0.0], "from": [3.3, 0.0],
        "velocity": {"sine": {"mean": 6.0, "amplitude": 15.0, "frequency": 1.7}},
        "table": [[-1.4, 0.0], [-0.3, 1.0], [0.8, 0.9], [0.9, 0.0]],
    }  # fmt: skip
    front = {"along": [2.0, -1.0], "from": [4.0, 9.0], "velocity": 12.0, "beyond": "hold",
             "table": [[-4.0, 0.3], [0.0, 1.0], [0.01, 0.0]]}  # fmt: skip
    everywhere = {"box": {"min": [-9.0, -9.0], "max": [99.0, 99.0]}}
    top = {"half-space": {"point": [0.0, 3.5], "normal": [0.0, -1.0]}}
    case = scene(
        2,
        {
            "ground": box([1.3, 1.0], [18.2, 4.2], None, "stiff"),
            "disk": {
                "material": "soft", "region": {"ball": {"centre": [9.1, 9.1], "radius": 2.3}},
                "velocity": [4.0, 0.5], "formulation": "total-lagrangian",
            },
        },
        cells=[20, 14],
        end=0.5,
        step={"courant": 0.15},
        materials=PAIR,
        boundaries={"y-min": "fixed"},
        tractions={
            "wheel": {"body": "ground", "region": top, "traction": [0.5, -3.0], "profile": wheel},
            "front": {"body": "disk", "region": everywhere, "pressure": 4.0, "profile": front},
            "weight": {"body": "ground", "region": top, "pressure": 0.5, "follower": False},
        },
        output={"every": 0.2, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )  # fmt: skip
    case["time"]["stages"] = [
        {"name": "faster", "end": 0.7, "tractions": {
            "wheel": {"profile": wheel | {"velocity": 18.0}}, "weight": {"pressure": 0.1},
        }},
        {"name": "anew", "end": 0.9, "tractions": {
            "wheel": {"profile": wheel | {"from": [16.0, 0.0], "velocity": -9.0}}, "weight": None,
        }},
    ]  # fmt: skip
    return case
