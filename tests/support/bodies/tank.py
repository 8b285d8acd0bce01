"""A tank of water, eight cells wide."""

from copy import deepcopy

from scenes import start

#: A tank 8 cells wide, filled to 8 cells; sound at ten times sqrt(g depth).
TANK = {
    "format": 1, "dimensions": 2, "grid": {"size": [8.0, 16.0], "cell": [1.0, 1.0]},
    "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
    "time": {"end": 1.0e3, "step": {"courant": 0.3}},
    "materials": {"water": {"model": "newtonian", "bulk": 800.0, "density": 1.0}},
    "bodies": {
        "water": {"material": "water", "region": {"box": {"min": [0.0, 0.0], "max": [8.0, 8.0]}}}
    },
    "gravity": [0.0, -1.0],
    "boundaries": {"x-min": "slip", "x-max": "slip", "y-min": "slip"},
}  # fmt: skip


def tank(**parts):
    """The tank's solver, with changes to its parts."""
    case = deepcopy(TANK)
    for name, part in parts.items():
        case[name] = {**case.get(name, {}), **part} if isinstance(part, dict) else part
    return start(case)
