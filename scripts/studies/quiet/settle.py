"""Settling: steps to rest over the highest frequency by the lowest one, and the error left then."""

from math import pi, sqrt

import numpy as np
from studies.scenes import box, by_id, case_of, core

from pgimp.case.stepping.courant import largest_courant, vertex_limit
from pgimp.case.stepping.steps import AUTO

#: Courant number of the cases; in the initial configuration settling takes its own.
COURANT = 0.4

RUBBER = {"model": "neo-hookean", "young": 1e6, "poisson": 0.3, "density": 1000.0}
WATER = {"model": "newtonian", "bulk": 2e5, "density": 1000.0}
MODULUS = RUBBER["young"] / (1.0 - RUBBER["poisson"] ** 2)


def beam(configuration, ratio=10, dimension=2):
    """A cantilever of a given slenderness, four cells high, under a pressure on its upper face."""
    length, h = 0.1 * ratio, 0.025
    wide = [0.1] * (dimension - 2)
    body = {
        "material": "m",
        "configuration": configuration,
        "region": box([0.0, *(0.0 for _ in wide), 0.3], [length, *wide, 0.4]),
    }
    faces = {"x-min": "fixed"} | {f"y-{end}": "slip" for end in ("min", "max") if wide}
    load = {"body": "b", "face": f"{'xyz'[dimension - 1]}-max", "pressure": 10.0 / ratio}
    return case_of(
        [length + 0.1, *wide, 0.7], h, {"m": RUBBER}, {"b": body}, 0.01,
        tractions={"p": load}, boundaries=faces, courant=COURANT,
    ), 3.516 / length**2 * sqrt(MODULUS * 0.1**2 / 12.0 / RUBBER["density"])  # fmt: skip


def column(configuration):
    """A column of twelve cells that begins to bear its weight, between smooth walls."""
    body = {
        "material": "m", "configuration": configuration, "region": box([0.0, 0.0], [0.1, 0.3]),
    }  # fmt: skip
    faces = {face: "slip" for face in ("x-min", "x-max", "y-min")}
    stiff = RUBBER["young"] * 0.7 / (1.3 * 0.4)
    return case_of(
        [0.1, 0.4], 0.025, {"m": RUBBER}, {"b": body}, 0.01, gravity=[0.0, -9.81],
        boundaries=faces, courant=COURANT,
    ), 0.5 * pi / 0.3 * sqrt(stiff / RUBBER["density"])  # fmt: skip


def plate():
    """A circular plate, held at its edge, under a pressure: a section of rings."""
    case, _ = beam("initial")
    case |= {"geometry": "axisymmetric", "boundaries": {"x-max": "fixed"}}
    case["grid"]["size"][0] = 1.0
    return case, 10.216 * sqrt(MODULUS * 0.1**2 / 12.0 / RUBBER["density"])


def tank():
    """Water in a tank of ten cells, under gravity that leans by a tenth."""
    body = {"material": "m", "region": box([0.0, 0.0], [1.0, 0.4])}
    faces = {face: "slip" for face in ("x-min", "x-max", "y-min")}
    return case_of(
        [1.0, 0.8], 0.1, {"m": WATER}, {"b": body}, 0.01, gravity=[1.0, -9.81],
        boundaries=faces, courant=COURANT,
    ), sqrt(9.81 * pi * np.tanh(0.4 * pi))  # fmt: skip


#: Name in the table: case with its lowest angular frequency, tolerance, and direction of the way.
SCENES = {
    "cantilever 10:1, pressure, `initial`": (lambda: beam("initial"), 1e-4, 1),
    "cantilever 20:1": (lambda: beam("initial", 20), 1e-4, 1),
    "cantilever 10:1, 3D": (lambda: beam("initial", 10, 3), 1e-4, 2),
    "cantilever 10:1, `current`": (lambda: beam("current"), 1e-4, 1),
    "circular plate, held edge, rings": (plate, 1e-4, 1),
    "column under its weight, `initial`": (lambda: column("initial"), 1e-4, 1),
    "column under its weight, `current`": (lambda: column("current"), 1e-4, 1),
    "water in a tilted tank, `current`": (tank, 1e-3, 1),
}


def rest(case, tolerance):
    """Settle a case: steps, the longest stable one, and places of particles before and after."""
    sim, dt = core(case | {"start": {"settle": {"tolerance": tolerance}}}), 0.0
    first = by_id(sim, sim.particles.x[sim.live()])
    while sim.settling:
        sim.advance()
        dt = max(dt, sim.dt)
    limit = largest_courant(sim.case)
    part = AUTO if vertex_limit(sim.case) else COURANT / limit
    return sim.step, dt / part, first, by_id(sim, sim.particles.x[sim.live()])


def row(name):
    """Line of the table: steps, the ratio of frequencies, steps over it, and the error left."""
    make, tolerance, axis = SCENES[name]
    case, frequency = make()
    steps, stable, first, found = rest(case, tolerance)
    ratio, error = 2.0 / (stable * frequency), "-"
    if "water" not in name:
        last = rest(case, 0.01 * tolerance)[-1]
        error = f"{np.abs(found - last)[:, axis].max() / np.abs(last - first)[:, axis].max():.0e}"
    return [name, f"{tolerance:.0e}", str(steps), f"{ratio:.0f}", f"{steps / ratio:.1f}", error]
