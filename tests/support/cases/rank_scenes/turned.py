"""Parts of bodies that are turned, in both configurations, in contact, in stages."""

from math import pi

from scenes import box, scene

from rank_scenes.entries import EVERYTHING, GRID, PAIR


def turned():
    """A rotor that moves across slabs as it turns, and a mixer that meets a block under a force.

    The rate of one follows a table, the axis of the other moves. A stage turns one back and lets
    the other go on without its rotation, the next ends it.
    """
    bodies = {
        "rotor": box([2.0, 6.0], [8.0, 8.0]) | {"formulation": "total-lagrangian"},
        "mixer": box([11.3, 2.2], [16.2, 4.4], None, "stiff"),
        "block": box([10.5, 5.4], [13.5, 7.4], [0.0, -1.0]) | {"formulation": "total-lagrangian"},
    }
    rate = {"table": [[0.0, 0.0], [0.3, pi], [1.2, pi]]}
    grips = {
        "hub": {
            "body": "rotor", "region": {"box": {"min": [3.5, 6.0], "max": [6.5, 8.0]}},
            "velocity": [{"table": [[0.0, 6.0], [0.8, 8.0]]}, 0.5],
            "rotation": {"about": [5.0, 7.1], "rate": rate},
        },
        "shaft": {
            "body": "mixer", "region": {"box": {"min": [13.0, 2.0], "max": [15.0, 5.0]}},
            "rotation": {"about": [14.0, 3.3], "rate": 2.0},
        },
        "press": {
            "body": "block", "region": {"box": {"min": [10.5, 6.5], "max": [13.5, 7.5]}},
            "velocity": [0.0, None], "force": [None, -8.0],
        },
    }  # fmt: skip
    case = scene(
        2,
        bodies,
        cells=[20, 12],
        shape="finite-gimp",
        end=0.5,
        step={"courant": 0.3},
        materials=PAIR,
        contact=[{"bodies": "all", "friction": 0.3}],
        constraints=grips,
        output={"every": 0.2, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [
        {"name": "back", "end": 0.8, "constraints": {
            "hub": {"rotation": {"about": [5.0, 7.1], "rate": -2.0}},
            "shaft": {"rotation": None, "velocity": [0.5, 0.0]},
        }},
        {"name": "free", "end": 1.0, "constraints": {"hub": None}},
    ]  # fmt: skip
    return case
