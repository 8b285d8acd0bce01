"""Scenes whose bodies cross slabs, for whole runs on several ranks."""

from exact_cases import bar, ramp, ring
from loaded_block import loaded
from scenes import BAR, SOFT, box, scene, wall

STIFF = {"model": "hooke", "young": 300.0, "poisson": 0.25, "density": 2.0}
#: Two models in the scenes with gimp; those with mpm share the kernels of other tests.
PAIR = {"soft": SOFT, "stiff": STIFF}
LINE = {"soft": BAR, "stiff": {**BAR, "young": 400.0, "density": 2.0}}
EVERYTHING = ["velocity", "stress", "deformation", "displacement"]
GRID = ["mass", "momentum", "velocity", "force"]
#: For `plane_leaves`: particles that leave, and places that are filled for a time.
PROBES = {
    "corner": {"body": "corner", "at": [13.0, 20.0]},
    "down": {"body": "down", "at": [2.0, 1.0], "every": 0.08},
    "gate": {"place": [15.5, 21.6], "every": {"steps": 3}},
    "floor": {"place": [3.0, 0.0]},
}


def turning(body, about, rate, velocity):
    """The same body, turning as it flies."""
    motion = {"rotation": {"about": about, "rate": rate}, "translation": velocity}
    return body | {"velocity": motion}


def line_gimp():
    """Two bars fly at each other past all slabs, collide, and leave the first slabs empty."""
    bodies = {"quick": box([1.0], [7.0], [8.0]), "slow": box([20.0], [26.0], [-2.0], "stiff")}
    return scene(
        1,
        bodies,
        cells=[40],
        end=2.0,
        step=0.01,
        materials=LINE,
        output={"every": 0.5, "fields": EVERYTHING},
        history={"every": {"steps": 20}},
    )


def line_slows():
    """Courant control; a bar flies against its weight, so that steps lengthen again and again."""
    return scene(
        1,
        box([24.0], [32.0], [-8.0]),
        cells=[40],
        end=2.0,
        step={"courant": 0.1},
        gravity=[4.0],
        output={"every": 0.5, "fields": EVERYTHING},
        history={"every": {"steps": 20}},
    )


def line_mpm():
    """Courant control, with stops; a bar falls on a floor, and a moving wall pushes another."""
    bodies = {"falls": box([1.0], [5.0], [-1.0]), "pushed": box([26.0], [30.0], [0.0])}
    ramp = [[0.0, [0.0]], [0.5, [-2.0]]]
    push = [[0.0, 0.0], [0.5, -0.4]]
    return scene(
        1,
        bodies,
        cells=[30],
        shape="mpm",
        per_cell=3,
        end=1.0,
        step={"courant": 0.1},
        gravity={"table": ramp},
        boundaries={"x-min": "separating", "x-max": wall(push)},
        output={"at": [0.3, 0.7], "fields": EVERYTHING},
        history={"every": 0.1},
    )


def plane_gimp(**parts):
    """Courant control; squares fly up and across, one turns, one is dragged along a wall.

    The upper and the lower one come into each layer together, in the order of neither's ids.
    """
    bodies = {
        "upper": box([6.0, 8.0], [7.0, 9.0], [2.0, 1.0]),
        "lower": box([6.0, 5.0], [7.0, 6.0], [2.0, 1.0], "stiff"),
        "flies": turning(box([1.0, 2.0], [4.0, 5.0]), [2.5, 3.5], 0.4, [4.0, 6.0]),
        "dragged": box([8.0, 0.0], [11.0, 2.0], None, "stiff"),
    }
    return scene(
        2,
        bodies,
        cells=[16, 24],
        end=1.5,
        step={"courant": 0.25},
        materials=PAIR,
        boundaries={"y-min": wall(-1.5, 0.0), "x-max": "slip"},
        **{
            "output": {"every": 0.4, "at": [0.77], "fields": EVERYTHING},
            "history": {"every": {"steps": 15}},
        }
        | parts,
    )


def plane_mpm():
    """Two turning squares pass each other, one up, one down."""
    bodies = {
        "up": turning(box([1.0, 2.0], [3.0, 4.0]), [2.0, 3.0], 0.5, [2.9, 5.3]),
        "down": turning(box([12.0, 6.0], [14.0, 8.0]), [13.0, 7.0], -0.4, [-3.1, -2.7]),
    }
    return scene(
        2,
        bodies,
        cells=[16, 18],
        shape="mpm",
        end=1.4,
        step=0.007,
        boundaries={"y-min": "fixed", "y-max": "slip"},
        output={"every": 0.35, "fields": EVERYTHING},
        history={"every": {"steps": 10}},
    )


def space_gimp():
    """Courant control; two blocks fly in y and z, collide on the way, one turns."""
    bodies = {
        "flies": turning(
            box([1.0, 1.0, 1.0], [3.0, 3.0, 3.0]), [2.0] * 3, [0.2, 0.3, 0.4], [5.0, 6.0, 7.0]
        ),
        "meets": box([5.0, 5.0, 6.0], [7.0, 7.0, 8.0], [0.0, 3.0, 3.0], "stiff"),
    }
    return scene(
        3,
        bodies,
        cells=[12, 12, 14],
        end=0.9,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, 0.0, -1.0],
        boundaries={"z-min": "separating", "y-max": "slip"},
        output={"every": 0.3, "fields": EVERYTHING},
        history={"every": 0.1},
    )


def space_mpm():
    """Long enough for a re-sort of the rows while a block crosses slabs."""
    block = box([1.0, 1.0, 1.0], [3.0, 3.0, 3.0])
    bodies = {
        "flies": turning(block, [2.0] * 3, [0.1, -0.4, 0.3], [3.7, 2.9, 4.1]),
        "stays": box([7.0, 1.0, 1.0], [9.0, 3.0, 2.0], None),
    }
    return scene(
        3,
        bodies,
        cells=[12, 8, 10],
        shape="mpm",
        end=1.05,
        step=0.007,
        boundaries={"z-min": "slip"},
        output={"every": 0.35, "fields": EVERYTHING},
        history={"every": {"steps": 25}},
    )


def narrow():
    """Three cells along x: room for four ranks at most."""
    body = box([0.0, 1.0, 1.0], [3.0, 3.0, 3.0], [0.0, 5.0, 3.0])
    second = box([0.0, 1.0, 6.0], [2.0, 2.0, 7.0], [0.4, 0.0, 0.0], "stiff")
    return scene(
        3,
        {"wide": body, "small": second},
        cells=[3, 12, 10],
        end=1.0,
        step=0.01,
        materials=PAIR,
        boundaries={"x-min": "slip", "x-max": "slip"},
        output={"every": 0.5, "fields": EVERYTHING, "grid": ["momentum"]},
        history={"every": {"steps": 20}},
        probes={"small": {"body": "small", "at": [1.0, 1.5, 6.5], "every": {"steps": 1}}},
    )


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


def squeezed(dimension, shape, faces, **parts):
    """Two blocks at the ends of the slabs, where mirrors are; the one at x-max hits the other."""
    low, high = [0.0] * dimension, [10.0, *[3.0] * (dimension - 1)]
    velocity = [0.8] * dimension
    bodies = {"wide": box(low, high, velocity)}
    if dimension > 1:
        start = [14.0, *[3.5] * (dimension - 1)]
        hit = box(start, [16.0, *[5.5] * (dimension - 1)], [-8.0, *[-2.5] * (dimension - 1)])
        rate = 0.5 if dimension == 2 else [0.2, 0.4, 0.5]
        bodies["hits"] = turning(hit, [c + 1.0 for c in start], rate, hit["velocity"])
    else:
        bodies["hits"] = box([14.0], [16.0], [-8.0])
    return scene(
        dimension,
        bodies,
        cells=[16, 8, 8][:dimension],
        shape=shape,
        per_cell=2 if dimension < 3 else 1,
        end=0.72,
        step={"courant": 0.25},
        gravity=[0.0] * (dimension - 1) + [-1.0],
        boundaries=faces,
        output={"every": 0.24, "fields": EVERYTHING, "grid": ["mass", "velocity", "force"]},
        history={"every": 0.12},
        probes={
            "corner": {"body": "hits", "at": bodies["hits"]["region"]["box"]["max"]},
            "between": {"place": [12.0, *[3.0] * (dimension - 1)], "every": {"steps": 4}},
        },
        **parts,
    )


#: The shapes whose size is tracked, and tents that stay; mirrors at x-min, x-max and elsewhere.
SIZED = {
    "line_fuzzy": squeezed(1, "fuzzy-constant", {"x-min": "fixed", "x-max": "separating"}),
    "plane_finite": squeezed(2, "finite-gimp", {"x-min": "slip", "y-min": "separating"}),
    "plane_corners": squeezed(
        2, "cpdi-corners", {"x-min": "slip", "y-min": "separating"}, wall="mirror"
    ),
    "space_corners": squeezed(3, "cpdi-corners", {"x-min": "fixed", "z-min": "slip"}),
    "plane_fuzzy": squeezed(
        2, "fuzzy-nearest", {"x-min": "slip", "x-max": "separating", "y-min": "separating"}
    ),
    "plane_ghost": squeezed(2, "bspline-cubic", {"x-min": "slip", "y-min": "fixed"}, wall="ghost"),
    "plane_mirror": squeezed(
        2, "gimp", {"x-min": "slip", "x-max": "separating", "y-min": "separating"}, wall="mirror"
    ),
    "space_finite": squeezed(3, "finite-gimp", {"x-min": "fixed", "z-min": "slip"}),
    "space_fuzzy": squeezed(
        3, "fuzzy-constant",
        {"x-min": "fixed", "x-max": "separating", "y-min": "slip", "z-min": "fixed"},
        size="fixed",
    ),
}  # fmt: skip
#: Long enough for looks at the energy, and for three checkpoints.
SIZED["plane_mirror"]["time"] = {"end": 2.4, "step": {"courant": "auto"}}


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
        boundaries={"y-min": "separating", "y-max": "slip"},
        tractions={"push": {"body": "lies", "face": "x-min", "pressure": 2.0}},
        constraints={"grip": grip | {"velocity": [0.0, None]}},
        contact=[
            {"bodies": "all", "friction": {"static": 0.5, "kinetic": 0.3}},
            {"bodies": ["lies", "glued"], "law": "tied"},
            {"bodies": ["ghost", "meets"], "law": "ignore"},
        ],
        output={"every": 0.25, "fields": EVERYTHING, "grid": [*GRID, "contact"]},
        history={"every": {"steps": 10}},
    )
    case["method"] |= {"affine": True, "relaxation": 2.0, "volumetric": "mean"}
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


#: Metals with all they may have: state of several widths, one with artificial viscosity.
METAL = {"young": 100.0, "poisson": 0.3, "density": 1.0}
METALS = {
    "soft": {"model": "von-mises", "yield-stress": 1.0, "hardening": 0.5, "kinematic": 2.0}
    | METAL | {"saturation": {"stress": 0.5, "rate": 5.0}},
    "stiff": METAL | {"model": "johnson-cook", "a": 1.0, "b": 2.0, "n": 0.4, "c": 0.05, "m": 1.1}
    | {"reference-rate": 0.1, "specific-heat": 0.02, "temperature": 1.0, "melting": 3.0}
    | {"damage": {"d1": 0.05, "d2": 0.1, "d3": -1.5, "d4": 0.01, "d5": 0.3}}
    | {"eos": {"mie-gruneisen": {"c0": 9.0, "s": 1.5, "gamma": 2.0}}}
    | {"viscosity": {"linear": 0.2, "quadratic": 1.0}},
}  # fmt: skip


def metals():
    """Squares of metals collide across slabs, flow, harden, heat and fail; affine."""
    bodies = {
        "flies": turning(box([1.0, 2.0], [5.0, 5.0]), [3.0, 3.5], 0.6, [6.0, 0.5]),
        "meets": box([8.0, 1.5], [12.0, 4.5], [-3.0, 0.2], "stiff"),
        "falls": box([14.0, 1.0], [17.0, 4.0], [-5.0, -1.0]),
    }
    states = ["plastic-strain", "back-stress", "temperature", "damage", "internal-energy"]
    case = scene(
        2,
        bodies,
        cells=[20, 8],
        end=1.0,
        step={"courant": 0.3},
        materials=METALS,
        boundaries={"y-min": "slip", "y-max": "separating"},
        output={"every": 0.25, "fields": [*EVERYTHING, *states]},
        history={"every": {"steps": 10}},
    )
    case["method"]["affine"] = True
    return case


def affine():
    """Particles of metals that carry their velocity gradient as they turn; empty slabs."""
    motion = {"rotation": {"about": [4.0, 3.0], "rate": 2.0}, "translation": [3.0, 0.5]}
    bodies = {
        "turns": box([3.0, 2.0], [5.2, 4.1], motion),
        "waits": box([12.0, 2.0], [13.0, 3.0], None, "stiff"),
    }
    case = scene(
        2,
        bodies,
        cells=[16, 8],
        end=1.0,
        materials=METALS,
        boundaries={"y-min": "slip", "y-max": "separating"},
        output={"fields": ["velocity", "stress", "deformation"]},
    )
    case["method"]["affine"] = True
    return case


def flowing():
    """Soils, grains, fluids and a gas beside a solid fly, fall on a floor, meet; with affine."""
    soil = {"young": 100.0, "poisson": 0.3, "density": 1.0, "cohesion": 0.3}
    soil |= {"friction-angle": 30.0, "dilation-angle": 5.0}
    liquid = {"bulk": 80.0, "density": 1.0, "shear-viscosity": 0.2}
    clay = {"m": 1.2, "lambda": 0.2, "kappa": 0.05, "void-ratio": 1.0, "density": 1.0}
    laws = {
        "soft": SOFT,
        "sand": {"model": "drucker-prager"} | soil | {"cohesion": 0.0},
        "rock": {"model": "mohr-coulomb"} | soil,
        "clay": {"model": "cam-clay", "shear": 30.0, "preconsolidation": 2.0} | clay,
        "grains": {
            "model": "mu-i", "young": 100.0, "poisson": 0.2, "density": 1.0, "mu-s": 0.4,
            "mu-2": 0.7, "i0": 0.3, "grain": 0.01, "grain-density": 2.0,
        },
        "water": {"model": "newtonian", "viscosity": {"linear": 0.1, "quadratic": 1.0}} | liquid,
        "mud": {"model": "bingham", "yield-stress": 1.0} | liquid,
        "gas": {
            "model": "ideal-gas", "gamma": 1.4, "energy": 4.0, "density": 0.5,
            "viscosity": {"linear": 0.5, "quadratic": 1.5},
        },
    }  # fmt: skip
    bodies = {}
    for i, name in enumerate(laws):
        column, row = i % 4, i // 4
        low = [1.0 + 3.5 * column, 1.0 + 4.0 * row]
        velocity = [4.0 - 0.7 * i, 1.0 - 3.0 * row]
        bodies[name] = box(low, [low[0] + 2.5, low[1] + 2.5], velocity, name)
    case = scene(
        2,
        bodies,
        cells=[24, 12],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.25},
        materials=laws,
        gravity=[0.0, -3.0],
        boundaries={"y-min": "separating", "x-min": "slip", "x-max": "slip"},
        escape={"y-max": "remove"},
        output={
            "every": 0.25,
            "fields": [*EVERYTHING, "gap", "plastic-work", "internal-energy", "viscous-work"],
        },
        history={"every": {"steps": 10}},
        probes={"gas": {"body": "gas", "at": [12.75, 6.25], "every": {"steps": 3}}},
    )
    case["method"]["affine"] = True
    return case


#: As `PAIR`, but stiffness and density of the one and Poisson's ratio of the other vary in space.
VARIED = {
    "soft": SOFT | {
        "young": {
            "random": {"mean": 100.0, "cov": 0.3, "correlation": [2.0, 1.0], "seed": 4},
            "times": {"table": [[0.0, 1.2], [8.0, 0.8]], "over": "depth", "surface": 8.0},
        },
        "density": {"layers": [[0.0, 1.0], [3.2, 1.7]], "over": "y"},
    },
    "stiff": STIFF | {"poisson": {"table": [[0.0, 0.1], [24.0, 0.4]], "over": "x"}},
}  # fmt: skip


def varied():
    """Squares whose materials vary in space collide across slabs and leave, in two stages."""
    bodies = {
        "flies": turning(box([1.0, 2.0], [5.0, 5.0]), [3.0, 3.5], 0.6, [6.0, 0.5]),
        "meets": box([8.0, 1.5], [12.0, 4.5], [-3.0, 0.2], "stiff"),
        "leaves": box([14.0, 1.0], [17.0, 4.0], [6.0, -1.0]),
    }
    case = scene(
        2,
        bodies,
        cells=[20, 8],
        end=1.3,
        step={"courant": "auto"},
        materials=VARIED,
        gravity=[0.0, -2.0],
        boundaries={"y-min": "slip", "y-max": "separating"},
        escape={"x-max": "remove"},
        output={
            "every": 0.25,
            "fields": [*EVERYTHING, "parameter-young", "parameter-density", "parameter-poisson"],
        },
        history={"every": {"steps": 10}},
        probes={"tip": {"body": "flies", "at": [5.0, 3.5]}},
    )
    later = {"name": "later", "end": 1.7, "gravity": [0.0, 0.0], "remove": ["leaves"]}
    case["time"] = {"end": 1.2, "step": {"courant": "auto"}, "stages": [later]}
    return case


def initial():
    """In the initial configuration: held, dragged, loaded and turning bodies fly out of the grid.

    Courant control; a rotor far across the slabs, two cut bodies that share vertices, and a frame
    of the grid between steps. Volumes are means over cells.
    """
    held = {"body": "bar", "region": {"box": {"min": [0.0, 1.0], "max": [1.0, 3.0]}}}
    disk = {"ball": {"centre": [8.3, 5.6], "radius": 1.4}}
    bodies = {
        "bar": box([0.0, 1.0], [7.0, 3.0], [0.0, 1.0]),
        "disk": {"material": "stiff", "region": disk, "velocity": [-3.0, 5.0]},
        "flap": box([9.8, 5.0], [11.4, 6.0]),
        "rotor": turning(box([12.5, 5.0], [15.5, 6.0]), [14.0, 5.5], 1.5, [9.0, 4.0]),
    }
    load = {"body": "bar", "face": "x-max", "pressure": {"table": [[0.0, 0.0], [1.0, 9.0]]}}
    return scene(
        2,
        {name: body | {"configuration": "initial"} for name, body in bodies.items()},
        cells=[16, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"x-min": "fixed"},
        constraints={"grip": held | {"velocity": [None, {"table": [[0.0, 0.0], [1.0, 3.0]]}]}},
        tractions={"push": load},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
        probes={
            "tip": {"body": "rotor", "at": [15.5, 5.5]},
            "gate": {"place": [15.0, 6.0], "every": {"steps": 3}},
        },
    ) | {"method": {"shape": "finite-gimp", "particles_per_cell": [2, 2], "volumetric": "mean"}}


def initial_stages():
    """Bonded bodies in the initial configuration, cut off the grid's lines, in stages.

    A grip begins and ends, bonds become friction and again bonds, one body is removed; a body in
    the current configuration flies up meanwhile, so that the window grows.
    """
    spin = {"rotation": {"about": [9.0, 3.0], "rate": 0.2}, "translation": [0.5, 0.4]}
    bodies = {
        "a": box([2.2, 2.3], [7.2, 4.3], spin),
        "b": box([7.2, 2.3], [12.0, 4.3], spin, "stiff"),
        "c": box([12.0, 2.3], [17.1, 4.3], spin),
    }
    bodies = {name: body | {"configuration": "initial"} for name, body in bodies.items()}
    bodies["bird"] = box([9.0, 5.0], [11.0, 6.0], [3.0, 9.0])
    held = {"body": "b", "region": {"box": {"min": [8.0, 2.0], "max": [9.0, 5.0]}}}
    tied = [{"bodies": ["a", "b"], "law": "tied"}, {"bodies": ["b", "c"], "law": "tied"}]
    case = scene(
        2,
        bodies,
        cells=[20, 20],
        shape="finite-gimp",
        end=0.3,
        step={"courant": 0.3},
        materials=PAIR,
        boundaries={"x-max": "slip"},
        contact=[{"bodies": "all", "friction": 0.3}, *tied],
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )
    case["method"]["volumetric"] = "mean"
    case["time"]["stages"] = [
        {"name": "grip", "end": 0.5, "constraints": {"grip": held | {"velocity": [None, 2.0]}}},
        {"name": "loose", "end": 0.7, "contact": [{"bodies": "all", "friction": 0.1}, tied[1]]},
        {"name": "bound", "end": 0.9, "constraints": {"grip": None}, "gravity": [0.0, -2.0],
         "contact": [{"bodies": "all", "friction": 0.1}, *tied]},
        {"name": "gone", "end": 1.1, "remove": ["c"], "boundaries": {"y-min": "fixed"}},
    ]  # fmt: skip
    return case


def initial_contact():
    """Bodies in the initial configuration meet, across slabs: each other, tools, a floor.

    One comes from far, one is held, one lies on another and slides, one is tied to it; a ram comes
    in, and a turning drum drags what falls onto it. Bodies leave their first slabs on the way.
    """
    disk = {"ball": {"centre": [4.3, 5.6], "radius": 1.4}}
    bodies = {
        "flies": {"material": "stiff", "region": disk, "velocity": [9.0, -1.0]},
        "lies": box([8.0, 0.0], [13.0, 2.0]),
        "slides": box([8.5, 2.0], [10.5, 4.0], [3.0, 0.0]),
        "glued": box([12.0, 2.0], [13.0, 3.5]),
        "falls": box([17.0, 4.0], [19.5, 6.0], [0.0, -3.0], "stiff"),
    }
    bodies = {name: body | {"configuration": "initial"} for name, body in bodies.items()}
    rotation = {"about": [18.0, 1.5], "rate": -4.0}
    bodies["drum"] = {"rigid": {"rotation": rotation},
                      "region": {"ball": {"centre": [18.0, 1.5], "radius": 1.7}}}  # fmt: skip
    bodies["ram"] = {"rigid": {"velocity": {"table": [[0.0, [6.0, 0.0]], [1.0, [2.0, 0.0]]]}},
                     "region": {"box": {"min": [-6.0, 2.0], "max": [2.5, 8.0]}}}  # fmt: skip
    return scene(
        2,
        bodies,
        cells=[24, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR,
        gravity=[0.0, -1.0],
        boundaries={"y-min": {"separating": {"friction": 0.2}}, "x-max": "slip"},
        contact=[
            {"bodies": "all", "friction": {"static": 0.4, "kinetic": 0.3}},
            {"bodies": ["lies", "glued"], "law": "tied"},
            {"bodies": ["lies", "drum"], "adhesion": {"normal": 1.0, "reach": 0.3}},
        ],
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
    )


def both_configurations():
    """Water falls on a plate in the initial configuration, which a free ball hits and a ram pushes.

    The plate is held, moves over the slabs and slides on a floor; the water leaves the domain.
    """
    water = {"model": "newtonian", "density": 1.0, "bulk": 200.0, "shear-viscosity": 0.3}
    held = {"body": "plate", "region": {"box": {"min": [4.0, 1.0], "max": [5.0, 3.0]}}}
    bodies = {
        "plate": box([4.0, 1.0], [16.0, 3.0]) | {"configuration": "initial"},
        "water": box([8.5, 3.6], [14.5, 6.4], [3.0, -2.0], "water"),
        "block": box([16.5, 0.0], [19.5, 2.0], [-3.0, 0.0], "stiff"),
        "ball": {"rigid": {"density": 3.0}, "velocity": [1.0, -4.0],
                 "region": {"ball": {"centre": [6.2, 5.2], "radius": 1.6}}},
        "ram": {"rigid": {"velocity": [-2.0, 0.0]},
                "region": {"box": {"min": [21.0, -1.0], "max": [26.0, 4.0]}}},
    }  # fmt: skip
    return scene(
        2,
        bodies,
        cells=[24, 8],
        shape="finite-gimp",
        end=1.0,
        step={"courant": 0.3},
        materials=PAIR | {"water": water},
        gravity=[0.0, -1.0],
        boundaries={"y-min": {"separating": {"friction": 0.2}}, "x-min": "slip"},
        escape={"x-max": "remove", "y-max": "remove"},
        contact=[{"bodies": "all", "friction": 0.3}],
        constraints={"grip": held | {"velocity": [None, {"table": [[0.0, 0.0], [1.0, 1.0]]}]}},
        output={"every": 0.25, "fields": EVERYTHING, "grid": GRID},
        history={"every": {"steps": 10}},
        probes={"tip": {"body": "plate", "at": [16.0, 3.0]}, "jet": {"place": [15.0, 4.0]}},
    ) | {"method": {"shape": "finite-gimp", "particles_per_cell": [2, 2], "volumetric": "mean"}}


def cut():
    """A tilted cylinder and a ball, which the lattice cuts, spinning."""
    motion = {
        "rotation": {"about": [1.5, -2.0, 0.3], "rate": [0.9, -0.4, 1.3]},
        "translation": [0.4, -0.3, 0.8],
    }
    pin = {"from": [3.7, 2.1, 2.2], "to": [6.4, 3.9, 3.1], "radius": 0.71}
    regions = {
        "ball": {"ball": {"centre": [2.03, 2.61, 2.57], "radius": 1.43}},
        "pin": {"cylinder": pin},
    }
    body = {"surface": "cut", "velocity": motion}
    bodies = {
        name: body | {"material": material, "region": regions[name]}
        for name, material in (("ball", "soft"), ("pin", "stiff"))
    }
    return scene(
        3,
        bodies,
        cells=[8, 6, 6],
        end=0.1,
        materials=PAIR,
        boundaries={"y-min": "slip"},
        output={"fields": EVERYTHING},
    )


#: Of cases with an exact solution.
_SHORT = {
    "shape": "finite-gimp",
    "output": {"every": 0.1, "fields": ["velocity", "stress", "displacement"]},
    "history": {"every": {"steps": 5}},
}
#: Body forces, initial velocities and the errors of exact solutions.
EXACT = {
    "ring": ring(0.125, end=0.2, **_SHORT),
    "bar": bar(
        {"compaction": {"dynamic": True}},
        gravity=ramp((0.0, 0.0), (1.0, -6.0)),
        end=0.5,
        step=0.005,
        **_SHORT,
    ),
}

SCENES = (
    {
        each.__name__: each()
        for each in (
            line_gimp,
            line_slows,
            line_mpm,
            plane_gimp,
            plane_mpm,
            space_gimp,
            space_mpm,
            narrow,
            line_leaves,
            plane_leaves,
            loaded,
            meeting,
            staged,
            flowing,
            initial,
            initial_stages,
            initial_contact,
            both_configurations,
            cut,
            metals,
            affine,
            varied,
        )
    }
    | SIZED
    | EXACT
    | {
        "other_output": plane_gimp(
            output={"every": {"steps": 7}, "at": [0.77], "fields": ["velocity"]},
            history={"every": 1.0},
        )
    }
)
