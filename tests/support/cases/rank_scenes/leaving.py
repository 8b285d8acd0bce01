"""Bodies leave the domain; probes on the way."""

from scenes import box, scene

from rank_scenes.entries import EVERYTHING, LINE, PAIR, turning

#: For `plane_leaves`: particles that leave, and places that are filled for a time.
PROBES = {
    "corner": {"body": "corner", "at": [13.0, 20.0]},
    "down": {"body": "down", "at": [2.0, 1.0], "every": 0.08},
    "gate": {"place": [15.5, 21.6], "every": {"steps": 3}},
    "floor": {"place": [3.0, 0.0]},
}


def line_leaves():
    """Two bars fly out of the domain; for the rest of the run there is nothing."""
    bodies = {"ahead": box([13.0], [16.0], [12.0], "stiff"), "behind": box([8.0], [11.0], [9.0])}
    return scene(
        1,
        bodies,
        cells=[20],
        end=1.8,
        step=0.01,
        materials=LINE,
        escape={"x-max": "remove"},
        output={"every": 0.3, "fields": EVERYTHING, "grid": ["mass"]},
        history={"every": {"steps": 20}},
        probes={"first": {"body": "ahead", "at": [16.0], "every": {"steps": 1}}},
    )


def sinks():
    """Two regions take out what comes into them; a body in the initial configuration stays."""
    bodies = {
        "jet": box([14.0, 4.0], [16.0, 7.0], [-9.0, 0.0]),
        "falls": turning(box([4.0, 8.0], [7.0, 10.0]), [5.5, 9.0], 1.5, [2.0, -6.0]),
        "stays": box([9.0, 8.0], [11.0, 10.0], [0.5, -6.0], "stiff")
        | {"formulation": "total-lagrangian"},
    }
    return scene(
        2,
        bodies,
        cells=[18, 12],
        end=1.0,
        step={"courant": 0.25},
        materials=PAIR,
        inflow={"jet": {"velocity": [-9.0, 0.0], "until": 0.6}},
        contact=[{"bodies": "all"}],
        boundaries={"y-max": "slip"},
        escape={
            "y-min": "remove",
            "drain": {"region": {"ball": {"centre": [5.0, 3.0], "radius": 2.5}}},
            "side": {"region": {"half-space": {"point": [9.0, 0.0], "normal": [1.0, 0.4]}}},
        },
        output={"every": 0.1, "fields": EVERYTHING},
        history={"every": {"steps": 1}},
    )


def plane_leaves():
    """Courant control; a square leaves through a corner, one through the slabs' side, one stays."""
    bodies = {
        "corner": turning(box([12.0, 19.0], [14.0, 21.0]), [13.0, 20.0], 0.5, [5.0, 6.0]),
        "down": box([2.0, 1.0], [6.0, 3.0], [1.0, -5.0], "stiff"),
        "stays": box([6.0, 10.0], [9.0, 12.0], [0.3, 0.2]),
    }
    return scene(
        2,
        bodies,
        cells=[16, 24],
        end=1.2,
        step={"courant": 0.25},
        materials=PAIR,
        escape={"x-min": "stop", "x-max": "remove", "y-min": "remove", "y-max": "remove"},
        output={"every": 0.1, "fields": EVERYTHING},
        history={"every": {"steps": 1}},
    )
