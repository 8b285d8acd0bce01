"""Settling: steps to rest over the highest frequency by the lowest one, and the error left then.

Each scene is a function of dimension ("2D", "3D" or "rings") and configuration. It gives the case,
the lowest angular frequency that its loads excite, the tolerance, and the body that is compared.
"""

from math import pi, sqrt

import numpy as np
from studies.scenes import box, by_id, case_of, core

from pgimp.case.stepping.courant import largest_courant, vertex_limit
from pgimp.case.stepping.steps import AUTO

COURANTS = (0.3, 0.6, "auto")
RUBBER = {"model": "neo-hookean", "young": 1e6, "poisson": 0.3, "density": 1000.0}
#: That of the beam CSM1 of Turek and Hron (2006).
SOFT = {"model": "neo-hookean", "young": 1.4e6, "poisson": 0.4, "density": 1000.0}
WATER = {"model": "newtonian", "bulk": 2e5, "density": 1000.0}
SOIL = {
    "model": "mohr-coulomb", "young": 2e7, "poisson": 0.3, "density": 2000.0,
    "cohesion": 1e4, "friction-angle": 30.0,
}  # fmt: skip
G = 9.81
#: Names of directions and faces in a section of x and the vertical, and in 3D.
VERTICAL = {"2D": "y", "rings": "y", "3D": "z"}


def plate_modulus(material):
    return material["young"] / (1.0 - material["poisson"] ** 2)


def confined(material):
    nu = material["poisson"]
    return material["young"] * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))


def lying(kind, x, z, y):
    """A box by its extents along x, upwards, and across the section."""
    return box(*zip(*((x, y, z) if kind == "3D" else (x, z)), strict=True))


def assembled(kind, size, cell, materials, bodies, faces, gravity, wide=None, **parts):
    """A case of a section of some size; in 3D it is `wide`, else one cell between smooth walls.

    `faces` have names as x-min, low and high; y-min and y-max are those of 3D only.
    """
    up, D = VERTICAL[kind], 3 if kind == "3D" else 2
    if D == 3:
        faces = {"y-min": "slip", "y-max": "slip"} | faces
        size = [size[0], wide or cell, size[1]]
    faces = {
        name.replace("low", f"{up}-min").replace("high", f"{up}-max"): entry
        for name, entry in faces.items()
        if entry and (D == 3 or name[0] != "y")
    }
    if kind == "rings":
        parts["geometry"] = "axisymmetric"
        faces.pop("x-min", None)
    pull = [gravity[0], 0.0, gravity[1]] if D == 3 else [*gravity]
    return case_of(size, cell, materials, bodies, 0.01, boundaries=faces, gravity=pull, **parts)


def pressed(kind, body, pressure):
    return {"p": {"body": body, "face": f"{VERTICAL[kind]}-max", "pressure": pressure}}


def strut(kind, configuration):
    """Ten times as high as thick, held below, under its weight and a pressure on its end."""
    body = {"material": "m", "formulation": configuration,
            "region": lying(kind, (0.0, 0.05), (0.0, 1.0), (0.0, 0.05))}  # fmt: skip
    stiff = plate_modulus(RUBBER) if kind == "2D" else RUBBER["young"]
    case = assembled(
        kind, (0.1, 1.1), 0.025, {"m": RUBBER}, {"b": body},
        {"x-min": "slip", "y-max": None, "low": "fixed"}, (0.0, -G), 0.1,
        tractions=pressed(kind, "b", 5e3),
    )  # fmt: skip
    return case, 0.5 * pi * sqrt(stiff / RUBBER["density"]), 1e-4, "b"


def column(kind, configuration):
    """Ten times as high as thick, under half of Euler's load and a small one across."""
    body = {"material": "m", "formulation": configuration,
            "region": lying(kind, (0.5, 0.6), (0.0, 1.0), (0.0, 0.025))}  # fmt: skip
    stiffness = plate_modulus(RUBBER) * 0.1**2 / 12.0
    push = 0.5 * 0.25 * pi**2 * stiffness
    loads = {"end": ("y-max", [0.0, -push]), "side": ("x-min", [5e-4 * push, 0.0])}
    case = assembled(
        kind, (1.1, 1.2), 0.025, {"m": RUBBER}, {"b": body}, {"low": "fixed"}, (0.0, 0.0),
        tractions={
            name: {"body": "b", "face": face, "traction": load}
            for name, (face, load) in loads.items()
        },
    )  # fmt: skip
    return case, 3.516 * sqrt(0.5 * stiffness / RUBBER["density"]), 1e-4, "b"


def cantilever(kind, configuration):
    """Ten times as long as high, four cells, under a pressure on its upper face."""
    body = {"material": "m", "formulation": configuration,
            "region": lying(kind, (0.0, 1.0), (0.3, 0.4), (0.0, 0.025))}  # fmt: skip
    case = assembled(
        kind, (1.1, 0.6), 0.025, {"m": RUBBER}, {"b": body}, {"x-min": "fixed"}, (0.0, 0.0),
        tractions=pressed(kind, "b", 1.0),
    )  # fmt: skip
    bends = sqrt(plate_modulus(RUBBER) * 0.1**2 / 12.0 / RUBBER["density"])
    return case, 3.516 * bends, 1e-4, "b"


def plate(kind, configuration):
    """A plate under its weight and a pressure, its edges held.

    A strip, a quarter of a square or a circle: ten or, of the square, five times as long as high.
    """
    a = 0.5 if kind == "3D" else 1.0
    body = {"material": "m", "formulation": configuration,
            "region": lying(kind, (0.0, a), (0.2, 0.3), (0.0, a))}  # fmt: skip
    held = {"2D": ("fixed", "fixed"), "rings": (None, "fixed"), "3D": ("fixed", "slip")}[kind]
    faces = {"x-min": held[0], "x-max": held[1], "y-min": held[0], "y-max": held[1]}
    case = assembled(
        kind, (a, 0.5), 0.05 if kind == "3D" else 0.025, {"m": RUBBER}, {"b": body}, faces,
        (0.0, -1.0), a, tractions=pressed(kind, "b", 100.0),
    )  # fmt: skip
    factor = {"2D": 22.37, "rings": 10.216, "3D": 35.99}[kind]
    bends = sqrt(plate_modulus(RUBBER) * 0.1**2 / 12.0 / RUBBER["density"])
    return case, factor * bends, 1e-4, "b"


def turek(kind, configuration):
    """The beam CSM1 of Turek and Hron: 17 times as long as high, bends by a fifth of its length."""
    body = {"material": "m", "formulation": configuration,
            "region": lying(kind, (0.0, 0.35), (0.12, 0.14), (0.0, 0.005))}  # fmt: skip
    case = assembled(
        kind, (0.4, 0.2), 0.005, {"m": SOFT}, {"b": body}, {"x-min": "fixed"}, (0.0, -2.0)
    )
    bends = sqrt(plate_modulus(SOFT) * 0.02**2 / 12.0 / SOFT["density"])
    return case, 3.516 / 0.35**2 * bends, 1e-4, "b"


def tilted(kind, configuration):
    """Water in a tank of ten cells, under gravity that leans by a tenth."""
    body = {"material": "water", "formulation": configuration,
            "region": lying(kind, (0.0, 1.0), (0.0, 0.4), (0.0, 0.3))}  # fmt: skip
    case = assembled(
        kind, (1.0, 0.8), 0.1, {"water": WATER}, {"b": body},
        {"x-min": "slip", "x-max": "slip", "low": "slip"}, (1.0, -G), 0.3,
    )  # fmt: skip
    return case, sqrt(G * pi * np.tanh(0.4 * pi)), 1e-3, ""


def lift(kind, configuration):
    """Ground under its weight, on half of which a stage puts a lift."""
    bodies = {
        "b": {"material": "m", "region": lying(kind, (0.0, 10.0), (0.0, 4.0), (0.0, 0.5))},
        "lift": {"material": "m", "region": lying(kind, (0.0, 5.0), (4.0, 5.0), (0.0, 0.5))},
    }
    case = assembled(
        kind, (10.0, 6.0), 0.5, {"m": SOIL}, bodies,
        {"x-min": "slip", "x-max": "slip", "low": "fixed"}, (0.0, -G),
    )  # fmt: skip
    case["time"]["stages"] = [{"name": "lift", "add": ["lift"], "equilibrate": {}}]
    return case, 0.5 * pi / 5.0 * sqrt(confined(SOIL) / SOIL["density"]), 1e-4, "b"


BOTH, ALL = ("initial", "current"), ("2D", "3D", "rings")
#: Scenes, their dimensions and configurations.
SCENES = {
    "strut 10:1, weight and pressure on its end": (strut, ALL, BOTH),
    "column 10:1, half of Euler's load, a little across": (column, ALL[:1], BOTH),
    "cantilever 10:1, pressure": (cantilever, ALL[:2], BOTH),
    "plate, weight and pressure": (plate, ALL, BOTH),
    "beam CSM1 of Turek and Hron": (turek, ALL[:2], BOTH),
    "water in a tilted tank": (tilted, ALL[:2], BOTH[1:]),
    "ground, a lift on half of it": (lift, ALL, BOTH[1:]),
}


def settled(case, tolerance):
    """Settle a case, or its stage: steps, the longest stable one, the way of the body "b".

    Raises NoRestError without rest.
    """
    rest, stages = {"equilibrate": {"tolerance": tolerance}}, case["time"].get("stages")
    start = {"stress": {"k0": 0.5}} | rest if stages else rest
    if stages:
        case = case | {"time": case["time"] | {"stages": [stages[0] | rest]}}
    sim, dt, last = core(case | {"start": start}), 0.0, 1 if stages else 0
    while last and not sim.stage_done:
        sim.advance()
    before, number = sim.step, int((sim.particles.body[sim.live()] == 0).sum())
    first = by_id(sim, sim.particles.x[sim.live()])[:number]
    while sim.settling if not last else not (sim.stage == last and sim.stage_done):
        sim.advance()
        dt = max(dt, sim.dt)
    part = AUTO if vertex_limit(sim.case) else sim.case.courant / largest_courant(sim.case)
    return sim.step - before, dt / part, by_id(sim, sim.particles.x[sim.live()])[:number] - first


def cell(name, kind, configuration, courant):
    """Steps, the ratio of frequencies, and the error of the ways; of water that of its centre."""
    case, frequency, tolerance, body = SCENES[name][0](kind, configuration)
    case["time"]["step"]["courant"] = courant
    steps, stable, way = settled(case, tolerance)
    ratio = 2.0 / (stable * frequency)
    if not body:  # hydrostatics: the surface is as steep as gravity leans
        exact = 0.1 / G * 10.0 / 12.0 / 0.4
        return steps, ratio, abs(way[:, 0].mean() / exact - 1.0)
    known = settled(case, 0.01 * tolerance)[-1]
    return steps, ratio, np.abs(way - known).max() / np.abs(known).max()


def rows(name):
    """Lines of the table: by dimension steps over the ratio of frequencies, and the error.

    With all bodies in the initial configuration settling takes its own Courant number.
    """
    _, kinds, configurations = SCENES[name]
    for kind in kinds:
        own = [cell(name, kind, "initial", 0.3)] if "initial" in configurations else []
        found = [cell(name, kind, "current", courant) for courant in COURANTS]
        parts = [f"{steps} ({steps / ratio:.1f})" for steps, ratio, _ in [*own, *found]]
        most = max(error for *_, error in [*own, *found])
        ratio = np.mean([ratio for _, ratio, _ in found])
        yield [name, kind, f"{ratio:.0f}", *(["-"] * (not own)), *parts, f"{most:.0e}"]
