"""Bodies that are damped on their way over the slabs."""

from scenes import box, scene

from rank_scenes.entries import EVERYTHING, GRID, PAIR


def damped():
    """Kinetic and mass-proportional damping, by stages, of bodies of both configurations.

    A beam that is held and a heap of cut parts fall onto a floor; another body flies over them.
    """
    held = {"body": "beam", "region": {"box": {"min": [0.0, 3.0], "max": [1.0, 5.0]}}}
    bodies = {
        "beam": box([0.0, 3.0], [9.0, 5.0]) | {"formulation": "total-lagrangian"},
        "block": box([10.3, 0.6], [14.0, 3.1], [0.5, -1.0], "stiff"),
        "flies": box([14.6, 3.0], [17.1, 5.0], [-4.0, 2.0]),
    }
    case = scene(
        2,
        bodies,
        cells=[20, 8],
        shape="finite-gimp",
        end=0.7,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -3.0],
        boundaries={"y-min": {"unilateral": {"friction": 0.2}}, "x-max": "slip"},
        contact=[{"bodies": "all", "friction": 0.3}],
        constraints={"grip": held | {"velocity": [0.0, {"table": [[0.0, 0.0], [1.0, 1.0]]}]}},
        damping={"kinetic": True},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["method"]["affine"] = True
    case["time"]["stages"] = [
        {
            "name": "slow",
            "end": 0.9,
            "damping": {"mass": 3.0},
            "constraints": {"grip": {"velocity": [0.0, None], "force": [None, 5.0]}},
        },
        {"name": "free", "end": 1.0, "damping": None},
        {"name": "rest", "end": 1.6, "damping": {"kinetic": True}},
    ]
    return case


def quaking():
    """Layers that slide on each other settle between absorbing faces; a wave comes; one face goes.

    Faces begin to absorb at the start and in a stage.
    """
    bodies = {
        "rock": box([0.0, 0.0], [20.0, 2.3], None, "stiff"),
        "soil": box([0.0, 2.3], [20.0, 5.0]),
    }
    case = scene(
        2,
        bodies,
        cells=[20, 7],
        shape="finite-gimp",
        end=0.6,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={
            "x-min": "absorbing",
            "x-max": "slip",
            "y-min": {"absorbing": {"held": "fixed"}},
        },
        contact=[{"bodies": "all", "friction": 0.3}],
        tractions={
            "knock": {
                "body": "soil",
                "face": "y-max",
                "traction": {"table": [[0.0, [0.0, 0.0]], [0.1, [1.0, -2.0]], [0.2, [0.0, 0.0]]]},
            }
        },
        start={"equilibrate": {"tolerance": 0.02}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [
        {"name": "wide", "end": 1.0, "boundaries": {"x-max": "absorbing", "x-min": None}},
        {"name": "all", "end": 1.4, "boundaries": {"x-min": "absorbing"}},
    ]
    return case


def heavy():
    """Layers across the slabs begin with the stress of their weight, which adds up over the ranks.

    A pulse meets the absorbing face under them.
    """
    bodies = {
        "low": box([0.0, 0.0], [9.3, 5.0], None, "stiff"),
        "high": box([9.3, 0.0], [17.0, 5.0]),
    }
    load = {"body": "high", "face": "x-max", "pressure": {"table": [[0.0, 0.0], [0.1, 5.0]]}}
    return scene(
        2,
        bodies,
        cells=[20, 5],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[-0.5, 0.0],
        boundaries={"x-min": "absorbing", "y-min": "slip", "y-max": "slip"},
        tractions={"push": load},
        start={"stress": {"k0": {"low": 0.4, "high": 0.6}}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )


def soaked():
    """As `heavy`, with a surcharge, in water whose level crosses slabs; it is drained at last.

    Inertia is twice as large.
    """
    case = heavy()
    case["time"]["mass-scaling"] = 2.0
    case["boundaries"]["x-min"] = "slip"
    case["tractions"] = {"fill": {"body": "high", "face": "x-max", "pressure": 2.0}}
    case["start"]["stress"]["surcharge"] = ["fill"]
    case["water"] = {"level": {"table": [[0.2, 12.2], [0.7, 6.3]]}, "density": 0.5}
    drained = {"level": 4.0, "density": 0.5, "bodies": ["low"]}
    case["time"]["stages"] = [{"name": "drained", "end": 1.4, "water": drained}]
    return case


def settled():
    """Two bodies come to rest on a floor before time 0, with local damping, and are pulled then."""
    held = {"body": "right", "region": {"box": {"min": [14.0, 0.0], "max": [16.0, 4.0]}}}
    load = {"body": "left", "face": "x-min", "pressure": {"table": [[0.0, 2.0], [0.4, 6.0]]}}
    bodies = {
        "left": box([1.3, 0.0], [7.3, 3.2]),
        "right": box([7.3, 0.0], [16.0, 4.0], None, "stiff"),
    }
    return scene(
        2,
        bodies,
        cells=[20, 7],
        shape="cpdi",
        end=0.8,
        step={"courant": "auto"},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"y-min": {"unilateral": {"friction": 0.3}}},
        constraints={
            "grip": held
            | {
                "velocity": [None, 0.0],
                "force": [{"table": [[0.0, 0.0], [0.5, 9.0]]}, None],
                "spring": {"stiffness": 20.0},
            }
        },
        tractions={
            "push": load,
            "sea": {
                "body": "left",
                "region": {"half-space": {"point": [4.0, 0.0], "normal": [1.0, 0.0]}},
                "hydrostatic": {"level": {"table": [[0.0, 2.0], [0.6, 3.0]]}, "density": 0.8},
            },
        },
        damping={"kinetic": True, "local": 0.2},
        start={"equilibrate": {"tolerance": 0.02}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )


def dug():
    """Stages settle: a body goes, a wave comes between absorbing faces, one gets softer, all rest.

    Loads, walls and contact begin and end between them.
    """
    case = quaking()
    case["start"] = {"stress": {"k0": 0.5}}
    case["bodies"]["lift"] = box([7.0, 5.0], [13.0, 6.0])
    case["time"]["end"] = 0.3
    case["time"]["stages"] = [
        {"name": "dig", "equilibrate": {"tolerance": 0.03}, "remove": ["lift"]},
        {"name": "wave", "end": 0.6, "tractions": {"knock": {"traction": [0.5, -0.5]}}},
        {
            "name": "soft",
            "equilibrate": {"tolerance": 0.03},
            "damping": {"kinetic": True, "mass": 0.5},
            "materials": {"soft": {"young": 60.0}},
            "boundaries": {"x-max": "absorbing", "x-min": "slip"},
        },
        {"name": "free", "end": 0.8, "tractions": {"knock": None}, "boundaries": {"x-min": None}},
        {"name": "last", "equilibrate": {"tolerance": 0.05, "steps": 5000}},
    ]
    return case


def pressed():
    """Bodies of both configurations rest again and again on a rigid one, with fixed steps."""
    bodies = {
        "table": {"rigid": {}, "region": {"box": {"min": [2.0, 0.0], "max": [18.0, 1.0]}}},
        "left": box([3.3, 1.0], [9.3, 4.2]) | {"formulation": "total-lagrangian"},
        "right": box([9.3, 1.0], [16.0, 5.0], None, "stiff"),
    }
    held = {"body": "right", "region": {"box": {"min": [14.0, 1.0], "max": [16.0, 5.0]}}}
    load = {"body": "right", "face": "y-max", "pressure": 1.0}
    case = scene(
        2,
        bodies,
        cells=[20, 7],
        shape="finite-gimp",
        end=0.2,
        step=0.01,
        materials=PAIR,
        gravity=[0.0, -1.0],
        contact=[{"bodies": "all", "friction": 0.3}],
        constraints={"grip": held | {"velocity": [0.0, {"table": [[0.2, 0.0], [0.3, 0.5]]}]}},
        tractions={"push": load},
        output={"every": {"steps": 20}, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [
        {"name": "rest", "equilibrate": {"tolerance": 0.05}},
        {"name": "lift", "end": 0.4},
        {
            "name": "again",
            "equilibrate": {"tolerance": 0.05},
            "constraints": {"grip": {"velocity": [0.0, 0.0]}},
            "tractions": {"push": {"pressure": 2.0}},
            "step": 0.008,
        },
        {"name": "last", "end": 0.48},
    ]
    return case
