"""Flows with a known result, on cells of a given size: what is measured, and the speed."""

from math import exp, pi
from pathlib import Path
from time import process_time

import numpy as np

import pgimp

ROOT = Path(__file__).resolve().parents[2]
G = 9.81


def done(case, **changes):
    """Run a case to its end; return the simulation and its particle-steps per second of CPU."""
    entry = pgimp.load(ROOT / f"cases/{case}.yaml", changes) if isinstance(case, str) else case
    sim = pgimp.Simulation(entry)
    began, count = process_time(), len(sim.particles["id"])
    while not sim.finished:
        sim.step(1)
    return sim, count * sim.steps / (process_time() - began)


def sod(cell):
    """Means over the plateaus of p, u and both densities, the middle three fifths of each."""
    sim, speed = done("sod", **{"grid.cell": [cell]})
    p, t = sim.particles, 0.2
    x, u = p["position"][:, 0], p["velocity"][:, 0]
    pressure, density = -p["stress"][:, 0], p["density"]
    contact, shock = 0.927453 * t, 1.752156 * t
    tail = contact - t * np.sqrt(1.4 * 0.303130 / 0.426319)
    found = []
    for low, high in ((tail, contact), (contact, shock)):
        inside = np.abs(x - 0.5 * (low + high)) < 0.3 * (high - low)
        found.append([float(each[inside].mean()) for each in (pressure, u, density)])
    left, right = found
    return (left[0], left[1], left[2], right[2]), speed


def channel(cell, model):
    """Velocity in the middle over the exact one, and of a plug its half-width."""
    entry = pgimp.load(ROOT / "cases/channel.yaml").materials["mud"].model_dump(by_alias=True)
    if model == "newtonian":
        for key in ("yield-stress", "shear"):
            del entry[key]
    law = {"materials.mud": entry | {"model": model}}
    end = 0.1 if model == "newtonian" else 0.25  # the ends of a faster column pull at it
    sim, speed = done("channel", **law, **{"grid.cell": [cell, cell], "time.end": end})
    x, v = sim.particles["position"], sim.particles["velocity"][:, 1]
    middle = np.abs(x[:, 1] - x[:, 1].mean()) < 0.1
    across, v = x[middle, 0], v[middle]
    centre = float(v[np.abs(across) < 0.01].mean())
    if model == "newtonian":
        exact = parabola(across, sim.time)
        return (centre / float(exact[np.abs(across) < 0.01].mean()),), speed
    tau = sim.particles["stress"][middle, 3]
    # Where the shear stress, linear across, is the yield stress.
    slope = float(np.polyfit(across, tau, 1)[0])
    return (centre / 0.178282, abs(196.2 / slope) / 0.02), speed


def parabola(x, t, half=0.05, mu=24.76136, density=1000.0):
    """Velocity of Newton's fluid that begins to fall between walls, by its series."""
    u = density * G * (half**2 - x**2) / (2.0 * mu)
    rate = mu * pi**2 / (4.0 * density * half**2)
    for k in range(30):
        q = 2 * k + 1
        size = 16.0 * density * G * half**2 / (mu * pi**3 * q**3) * (-1) ** k
        u = u - size * np.cos(0.5 * q * pi * x / half) * exp(-q * q * rate * t)
    return u


def hydrostatic(cell):
    """Water at rest: pressure against depth, root mean square of the error over the greatest."""
    law = {"model": "newtonian", "bulk": 2.0e5, "density": 1000.0, "shear-viscosity": 20.0}
    case = {
        "format": 1,
        "dimensions": 2,
        "grid": {"size": [0.4, 0.4], "cell": [cell, cell]},
        "method": {"shape": "gimp", "particles_per_cell": [2, 2], "volumetric": "mean"},
        "time": {"end": 1.0, "step": {"courant": 0.3}},
        "materials": {"water": law},
        "bodies": {
            "pool": {"material": "water", "region": {"box": {"min": [0, 0], "max": [0.4, 0.2]}}}
        },
        "gravity": {"table": [[0.0, [0.0, 0.0]], [0.4, [0.0, -G]]]},
        "boundaries": {"x-min": "slip", "x-max": "slip", "y-min": "slip"},
    }
    sim, speed = done(case)
    y, p = sim.particles["position"][:, 1], -sim.particles["stress"][:, :3].mean(axis=1)
    top = y.max() + 0.25 * cell
    off = p - 1000.0 * G * (top - y)
    return (float(np.sqrt(np.mean(off**2))) / (1000.0 * G * 0.2),), speed


def column(cell, model):
    """Mean height of a column of sand at 0.75 s (Tesserae.jl's: 0.1184)."""
    law = {"materials.sand.model": model}
    sim, speed = done("sand-column", **law, **{"grid.cell": [cell, cell], "time.end": 0.75})
    return (float(sim.particles["position"][:, 1].mean()),), speed


def bank(cell, cohesion):
    """Greatest settlement of the bank, in its height, at 1.5 s."""
    changes = {"grid.cell": [cell, cell], "materials.clay.cohesion": cohesion}
    sim, speed = done("slope", **changes)
    return (float(-sim.particles["displacement"][:, 1].min()) / 2.0,), speed


def footing(cell, volumetric):
    """Pressure under a rough strip on clay over c: mean while it sinks from 0.12 to 0.18 cells.

    The strip's edge is in the middle of a cell, up to which the vertices press that it is on.
    """
    half = 1.0 + 0.5 * cell
    changes = {
        "grid.cell": [cell, cell], "method.volumetric": volumetric,
        "bodies.strip.region.box.max": [half, 3.0],
        "bodies.strip.rigid.velocity.table": [[0.0, [0.0, 0.0]], [0.1, [0.0, -0.4 * cell]]],
    }  # fmt: skip
    sim = pgimp.Simulation(pgimp.load(ROOT / "cases/footing.yaml", changes))
    began, count, forces = process_time(), len(sim.particles["id"]), []
    for time in np.linspace(0.35, 0.5, 31):
        sim.advance(time)
        forces.append(sim.diagnostics()["tool.strip.force-y"])
    speed = count * sim.steps / (process_time() - began)
    return (float(np.mean(forces[1:])) / (half * 1.0e4),), speed
