"""Metals against exact results: paths, waves, shocks, heat, and a cylinder thrown at a wall."""

import numpy as np
from studies.harness import CASES
from studies.scenes import box, case_of, filled, looked

import pgimp

STEEL = {
    "model": "von-mises", "young": 200e9, "poisson": 0.3, "density": 7850.0, "yield-stress": 400e6,
}  # fmt: skip
COPPER = {
    "model": "johnson-cook", "young": 129e9, "poisson": 0.34, "density": 8960.0, "a": 90e6,
    "b": 292e6, "n": 0.31, "c": 0.025, "m": 1.0, "reference-rate": 1.0, "specific-heat": 383.0,
    "temperature": 294.0, "melting": 1356.0,
}  # fmt: skip
#: Hardly any strength: what is left is the equation of state.
FLUID_COPPER = {
    "model": "johnson-cook", "young": 1.0e3, "poisson": 0.3, "density": 8930.0, "a": 1.0,
    "specific-heat": 383.0, "temperature": 294.0, "melting": 1356.0,
    "viscosity": {"linear": 0.3, "quadratic": 2.0},
}  # fmt: skip
TAYLOR = {
    "model": "von-mises", "young": 117e9, "poisson": 0.35, "density": 8930.0,
    "yield-stress": 400e6, "hardening": 100e6,
}  # fmt: skip


def finished(case):
    """A simulation at its end, and its particle-steps per second of CPU time."""
    _, rate, simulation = looked(case, (np.inf,), lambda sim: None)
    return simulation, rate


def paths():
    """Greatest relative error of J2 along exact paths, in one step and in a hundred."""
    worst = 0.0
    E, nu, limit, H = 200e9, 0.3, 400e6, 2e9
    G, K = E / (2 * (1 + nu)), E / (3 * (1 - 2 * nu))
    for steps in (1, 100):
        e = 0.3 * np.arange(1, steps + 1) / steps
        for sign in (0.0, -1.0):
            F = np.array([np.diag(np.exp([x, sign * x, 0.0])) for x in e])
            found = pgimp.element(STEEL | {"hardening": H}, F)
            trial = (2.0 if sign == 0.0 else 2.0 * np.sqrt(3.0)) * G * e
            alpha = (trial - limit) / (3 * G + H)
            radius = limit + H * alpha
            tau = K * e + 2 / 3 * radius if sign == 0.0 else radius / np.sqrt(3.0)
            volume = np.exp(e * (1.0 + sign))
            errors = found["plastic-strain"] / alpha - 1, found["stress"][:, 0] * volume / tau - 1
            worst = max(worst, *(np.abs(each).max() for each in errors))
    return worst


def heating(steps):
    """Rise of temperature at a plastic strain of 1, at a rate of 1000/s."""
    e = 1.02 * np.arange(1, steps + 1) / steps
    F = np.array([np.diag(np.exp([x, -0.5 * x, -0.5 * x])) for x in e])
    found = pgimp.element(COPPER, F, 1.02 / steps / 1e3)
    return float(np.interp(1.0, found["plastic-strain"], found["temperature"] - 294.0))


def plates_case(material, half, speed, cells, end):
    """Two plates of some thickness that fly at each other."""
    domain, cell = 2.5 * half, half / cells
    bodies = {
        name: {"material": "metal", "velocity": [way]} | filled([low], [low + half])
        for name, low, way in (("left", -half, speed), ("right", 0.0, -speed))
    }
    return case_of(
        [domain], cell, {"metal": material}, bodies, end, courant=0.2,
        grid={"origin": [-0.5 * domain]}, method={"shape": "finite-gimp"},
    )  # fmt: skip


def profile(simulation, cells):
    """Initial place over the thickness and axial pressure of the right plate, by cells."""
    particles = simulation.particles
    right = particles["body"] == 1
    p = -particles["stress"][right, 0]
    return (np.arange(cells) + 0.5) / cells, 0.5 * (p[0::2] + p[1::2])


def front(place, pressure, level):
    """Where the pressure last exceeds a level, linear between cells."""
    last = np.flatnonzero(pressure > level)[-1]
    a, b = pressure[last], pressure[last + 1]
    return place[last] + (a - level) / (a - b) * (place[last + 1] - place[last])


def elastic_plastic(cells):
    """Precursor and plastic wave: speeds, stresses behind them, and particle-steps/s."""
    half = 0.02
    material = STEEL | {"viscosity": {"linear": 0.1, "quadratic": 1.0}}
    case = plates_case(material, half, 25.0, cells, 2.6e-6)
    ways, rate = [], 0.0
    for end in (1.3e-6, 2.6e-6):
        simulation, rate = finished(case | {"time": {"end": end, "step": {"courant": 0.2}}})
        place, pressure = profile(simulation, cells)
        ways.append([half * front(place, pressure, level) for level in (350e6, 876.75e6)])
    first, second = ((b - a) / 1.3e-6 for a, b in zip(*ways, strict=True))
    fast, slow = (way / half for way in ways[1])
    between = (place > slow + 0.25 * (fast - slow)) & (place < fast - 0.25 * (fast - slow))
    behind = (place > 0.25 * slow) & (place < 0.8 * slow)
    return first, second, pressure[between].mean(), pressure[behind].mean(), rate


def hugoniot(cells, gamma=1.99):
    """Pressure, density and shock speed of copper that meets copper at 500 m/s."""
    half = 0.016
    law = {"c0": 3933.0, "s": 1.489, "gamma": gamma}
    material = FLUID_COPPER | {"eos": {"mie-gruneisen": law}}
    case = plates_case(material, half, 250.0, cells, 2.4e-6)
    ways, rate = [], 0.0
    for end in (1.2e-6, 2.4e-6):
        simulation, rate = finished(case | {"time": {"end": end, "step": {"courant": 0.2}}})
        place, pressure = profile(simulation, cells)
        ways.append(half * front(place, pressure, 4.8e9))
    behind = (place > 0.1) & (place < 0.8 * ways[1] / half)
    particles = simulation.particles
    right = particles["body"] == 1
    dense = (particles["mass"] / particles["volume"])[right]
    dense = 0.5 * (dense[0::2] + dense[1::2])[behind].mean() / 8930.0
    return pressure[behind].mean(), dense, (ways[1] - ways[0]) / 1.2e-6, rate


def taylor_case(cells, **method):
    """A quarter of a copper cylinder that hits a wall, with cells to its radius."""
    radius, length = 3.2e-3, 32.4e-3
    cell = radius / cells
    wide = np.ceil(8.2e-3 / cell) * cell
    size = [float(np.ceil(33.0e-3 / cell) * cell), float(wide), float(wide)]
    bar = {"cylinder": {"from": [0.0] * 3, "to": [length, 0.0, 0.0], "radius": radius}}
    quarter = box([0.0] * 3, [length, radius, radius])
    body = {"region": {"intersection": [bar, quarter]}, "velocity": [-227.0, 0.0, 0.0]}
    return case_of(
        size, cell, {"copper": TAYLOR}, {"bar": {"material": "copper"} | body}, 80e-6,
        method={"volumetric": "b-bar", "affine": True} | method,
        boundaries={"x-min": "slip", "y-min": "slip", "z-min": "slip"},
    )  # fmt: skip


def taylor(cells, **method):
    """Length and radius in mm, greatest plastic strain, and particle-steps/s at 80 microseconds."""
    simulation, rate = finished(taylor_case(cells, **method))
    particles = simulation.particles
    place, F = particles["position"], particles["deformation"].reshape(-1, 3, 3)
    half = 0.25 * simulation.case.grid.cell[0]
    radius = np.hypot(place[:, 1], place[:, 2])
    out = np.stack([0.0 * radius, place[:, 1] / radius, place[:, 2] / radius], axis=1)
    # Half a particle's box as it is now, along the axis and away from it.
    length = (place[:, 0] + half * np.linalg.norm(F[:, 0], axis=1)).max()
    away = radius + half * np.linalg.norm(np.einsum("nij,ni->nj", F, out), axis=1)
    return 1e3 * length, 1e3 * away.max(), particles["plastic-strain"].max(), rate


def tube(cells):
    """Pressure in a tube all of which yields, over the exact one of its radii then; and speed.

    The pressure is that of the filling two coarse cells and more from all surfaces, mean over the
    last fifth of the time. The radii are those of the area by which the bore has grown.
    """
    changes = {
        "grid.cell": [1.0 / cells] * 2,
        "format": 1,
        "method": {"shape": "gimp", "particles-per-cell": [2, 2], "volumetric": "b-bar"},
        "time.step": {"courant": 0.3},
        "contact": [{"bodies": ["filling", other]} for other in ("piston", "tube")],
    }
    simulation = pgimp.Simulation(CASES / "thick-tube.yaml", None, changes)
    particles = simulation.particles
    place = particles["position"]
    start, deep = np.hypot(*place.T), place[:, 1] > 0.6
    tube = particles["body"] == 0
    inside = ~tube & (start < 0.8) & deep

    def over_exact(simulation):
        grown = np.mean(np.hypot(*particles["position"][tube].T) ** 2 - start[tube] ** 2)
        exact = np.log((4.0 + grown) / (1.0 + grown)) / np.sqrt(3.0)
        return -particles["stress"][inside, :3].mean() / exact

    found, rate, _ = looked(simulation, np.linspace(2.0, 2.5, 26), over_exact)
    return np.mean(found), rate
