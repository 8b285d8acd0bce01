"""Metals, soils, fluids; materials that vary in space."""

from scenes import SOFT, box, scene

from rank_scenes.entries import EVERYTHING, STIFF, turning

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
        boundaries={"y-min": "slip", "y-max": "unilateral"},
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
        boundaries={"y-min": "slip", "y-max": "unilateral"},
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
        boundaries={"y-min": "unilateral", "x-min": "slip", "x-max": "slip"},
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
        boundaries={"y-min": "slip", "y-max": "unilateral"},
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
