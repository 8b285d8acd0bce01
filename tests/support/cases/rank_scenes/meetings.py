"""Contact in the current configuration, also in stages; by surfaces, of what lies or is folded."""

from scenes import SOFT, box, scene

from rank_scenes.entries import EVERYTHING, GRID, STIFF


def meeting():
    """Bodies that come near each other and part, with friction, tied, at walls and constraints.

    A rigid ram comes from one end of the grid, a rigid wheel turns between them, and a rigid ball
    moves freely. Cells have one rate of dilatation each, with most that goes with it: see `mean`.
    """
    rubber = {**SOFT, "poisson": 0.45, "viscosity": {"linear": 0.2, "quadratic": 2.0}}
    bodies = {
        "flies": box([1.0, 2.0], [4.0, 5.0], [6.0, 0.4]),
        "meets": box([12.0, 2.5], [15.0, 5.5], [-5.0, -0.4], "stiff"),
        "lies": box([7.0, 0.0], [10.0, 2.0]),
        "glued": box([7.0, 2.0], [9.0, 3.5]),
        "ghost": box([5.0, 6.0], [6.0, 7.0], [3.0, -4.0]),
        "ram": {
            "rigid": {"velocity": {"table": [[0.0, [-9.0, 0.0]], [1.0, [-4.0, 0.5]]]}},
            "region": {"box": {"min": [15.3, 1.0], "max": [24.0, 7.0]}},
        },
        "wheel": {
            "rigid": {"rotation": {"about": [11.4, 1.2], "rate": 6.0}},
            "region": {
                "union": [
                    {"ball": {"centre": [11.4, 1.2], "radius": 1.2}},
                    {"box": {"min": [10.8, 0.9], "max": [12.9, 1.5]}},
                ]
            },
        },
        "ball": {
            "rigid": {"density": 2.0},
            "velocity": {
                "rotation": {"about": [6.3, 3.6], "rate": 2.0},
                "translation": [-1.0, 0.0],
            },
            "region": {"ball": {"centre": [6.3, 4.4], "radius": 0.9}},
        },
    }
    grip = {"body": "lies", "region": {"box": {"min": [7.0, 0.0], "max": [8.0, 2.0]}}}
    case = scene(
        2,
        bodies,
        cells=[20, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials={"soft": rubber, "stiff": STIFF},
        gravity=[0.0, -2.0],
        boundaries={"y-min": "unilateral", "y-max": "slip"},
        tractions={"push": {"body": "lies", "face": "x-min", "pressure": 2.0}},
        constraints={"grip": grip | {"velocity": [0.0, None]}},
        contact=[
            {"bodies": "all", "friction": {"static": 0.5, "kinetic": 0.3}},
            {"bodies": ["lies", "glued"], "law": "tie"},
            {"bodies": ["ghost", "meets"], "law": "ignore"},
        ],
        output={"every": 0.25, "fields": EVERYTHING, "grid": [*GRID, "contact"]},
        history={"every": {"steps": 10}},
    )
    case["method"] |= {"affine": True, "relaxation": 2.0, "volumetric": "b-bar"}
    return case


def staged():
    """The same in three stages: bodies are taken out, also a rigid one, and all may change.

    The second stage begins between two re-sorts, the third with steps of another kind.
    """
    case = meeting()
    case["probes"] = {"ghost": {"body": "ghost", "at": [5.5, 6.5]}, "gap": {"place": [10.0, 3.0]}}
    catch = {"body": "glued", "region": {"box": {"min": [0.0, 0.0], "max": [20.0, 8.0]}}}
    case["time"] = {
        "end": 0.4,
        "step": {"courant": 0.3},
        "stages": [
            {
                "name": "without", "end": 0.7, "remove": ["ghost", "ram"], "step": 0.01,
                "materials": {"soft": {"young": 60.0}, "stiff": {"young": 200.0}},
                "constraints": {"grip": {"velocity": [1.0, 0.5]}},
                "contact": [{"bodies": "all", "friction": 0.1}],
                "output": {"every": 0.1}, "history": {"every": {"steps": 1}},
            },
            {
                "name": "last", "end": 1.0, "step": {"courant": 0.25}, "remove": ["flies"],
                "gravity": [2.0, 0.0], "boundaries": {"y-max": None, "x-max": "slip"},
                "constraints": {"grip": None, "catch": catch | {"velocity": [-0.5, None]}},
            },
        ],
    }  # fmt: skip
    return case


def phased():
    """The same without the ball, between mirrors, with stress in two halves."""
    case = meeting()
    del case["bodies"]["ball"]
    case["method"] |= {"stress": "average", "wall": "mirror"}
    return case


def surface_blocks():
    """In 3D blocks of other lattices on each other, whose facets are joined; one tilts off."""
    tilts = {"rotation": {"about": [8.1, 3.0, 1.9], "rate": [0.1, 0.9, 0.0]}}
    bodies = {
        "base": box([2.03, 1.1, 0.0], [8.1, 4.9, 1.9]) | {"formulation": "total-lagrangian"},
        "lies": box([2.4, 1.4, 1.9], [4.9, 4.4, 3.4]) | {"formulation": "total-lagrangian"},
        "tilts": box([6.3, 1.3, 1.9], [9.6, 4.6, 3.9])
        | {"formulation": "total-lagrangian"}
        | {"velocity": tilts},
    }
    return scene(
        3,
        bodies,
        cells=[14, 6, 6],
        end=0.9,
        step={"courant": 0.35},
        materials={"soft": SOFT | {"young": 200.0}},
        gravity=[0.0, 0.0, -4.0],
        boundaries={"z-min": {"unilateral": {"friction": 0.2}}},
        contact=[{"bodies": "all", "friction": 0.2}],
        output={"every": 0.3, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )


def surface_folded():
    """A plate folds a fork across slabs until its arms meet, and is taken off; it springs back."""
    whole, slot = ({"box": {"min": low, "max": high}} for low, high in (
        ([2.2, 0.0], [15.1, 5.5]), ([4.0, 1.6], [16.0, 3.7])))  # fmt: skip
    bodies = {
        "fork": {"material": "soft", "formulation": "total-lagrangian",
                 "region": {"difference": [whole, slot]}},
        "plate": {"rigid": {"velocity": [0.0, -3.0]},
                  "region": {"box": {"min": [7.0, 5.52], "max": [20.0, 7.0]}}},
    }  # fmt: skip
    case = scene(
        2,
        bodies,
        cells=[18, 8],
        end=0.85,
        step={"courant": 0.35},
        boundaries={"y-min": {"unilateral": {"friction": 0.2}}},
        contact=[{"bodies": "all", "friction": 0.2}, {"bodies": ["fork"], "self": True}],
        output={"every": 0.4, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )
    case["time"]["stages"] = [{"name": "off", "end": 1.3, "remove": ["plate"]}]
    return case
