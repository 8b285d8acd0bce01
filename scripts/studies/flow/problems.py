"""Flows with a known result, on cells of a given size: what is measured, and the speed."""

from math import exp, pi
from time import process_time

import numpy as np
from studies.harness import CASES
from studies.scenes import box, case_of, filled, looked, reading

import pgimp

G = 9.81

#: The dam break as it is measured: walls that lose what is beyond, and a weight that comes at once.
PLAIN = {"method.wall": "ghost", "start.stress": None}


def done(case, look=None, every=10, **changes):
    """Run a case to its end; return the simulation and its particle-steps per second of CPU.

    `look`, if given, sees the simulation after `every` steps, and ends it when it returns true.
    """
    entry = pgimp.load(CASES / f"{case}.yaml", changes) if isinstance(case, str) else case
    sim, spent = pgimp.Simulation(entry), 0.0
    count = len(sim.particles["id"])
    while not sim.finished:
        began = process_time()
        sim.step(1)
        spent += process_time() - began
        if look and sim.steps % every == 0 and look(sim):
            break
    return sim, count * sim.steps / spent


#: Shock tubes of ideal gases: time, p, u and both densities between the waves, shock's speed, case.
TUBES = {
    "sod": (0.2, 0.303130, 0.927453, 0.426319, 1.752156, {}),
    "uintah": (
        5.0e-4, 28858.3, 285.115, 0.479850, 558.115,
        {
            "time.end": 5.0e-4, "output.every": 1.0e-4, "history.every": 1.0e-4,
            "materials.left.density": 1.1768, "materials.left.energy": 717.5 * 300.0,
            "materials.right.density": 0.11768, "materials.right.energy": 717.5 * 300.0,
        },
    ),
}  # fmt: skip


def tube(cell, name):
    """Means over the plateaus of p, u, both densities, the middle three fifths; shock's speed."""
    t, p, u, dense, fast, changes = TUBES[name]
    sim, speed = done("sod", **changes, **{"grid.cell": [cell]})
    particles = sim.particles
    x, velocity = particles["position"][:, 0], particles["velocity"][:, 0]
    pressure, density = -particles["stress"][:, 0], particles["density"]
    contact, shock = u * t, fast * t
    tail = contact - t * np.sqrt(1.4 * p / dense)
    found = []
    for low, high in ((tail, contact), (contact, shock)):
        inside = np.abs(x - 0.5 * (low + high)) < 0.3 * (high - low)
        found.append([float(each[inside].mean()) for each in (pressure, velocity, density)])
    left, right = found
    # Where the pressure is half of what the shock brings; two particles lie in a cell.
    order = np.argsort(x)
    x, pressure = x[order], pressure[order]
    half = 0.5 * (left[0] + pressure[-1])
    last = int(np.flatnonzero(pressure > half)[-1])
    part = (pressure[last] - half) / (pressure[last] - pressure[last + 1])
    front = float(x[last] + part * (x[last + 1] - x[last])) / t
    return (left[0], left[1], left[2], right[2], front), speed


def channel(cell, model):
    """Velocity in the middle over the exact one, and of a plug its half-width."""
    entry = pgimp.load(CASES / "channel.yaml").materials["mud"].model_dump(by_alias=True)
    if model == "newtonian":
        for key in ("yield-stress", "shear"):
            del entry[key]
    law = {"materials.mud": entry | {"model": model}}
    end = 0.1 if model == "newtonian" else 0.25  # the ends of a faster column pull at it
    longer = {"grid.size": [0.1, 2.8], "bodies.column.region.box.max": [0.05, 2.5]}
    changes = law | longer | {"grid.cell": [cell, cell], "time.end": end}
    sim, speed = done("channel", **changes)
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
    pool = {"material": "water"} | filled([0.0, 0.0], [0.4, 0.2])
    sim, speed = done(case_of(
        [0.4, 0.4], cell, {"water": law}, {"pool": pool}, 1.0, method={"volumetric": "b-bar"},
        gravity={"table": [[0.0, [0.0, 0.0]], [0.4, [0.0, -G]]]},
        boundaries={"x-min": "slip", "x-max": "slip", "y-min": "slip"},
    ))  # fmt: skip
    y, p = sim.particles["position"][:, 1], -sim.particles["stress"][:, :3].mean(axis=1)
    top = y.max() + 0.25 * cell
    off = p - 1000.0 * G * (top - y)
    return (float(np.sqrt(np.mean(off**2))) / (1000.0 * G * 0.2),), speed


def dam(cell):
    """Instant at which water of a broken dam is at the far wall."""

    def there(sim):
        return sim.particles["position"][:, 0].max() > 3.22 - 0.5 * cell

    changes = {"grid.cell": [cell, cell], "time.end": 1.0} | PLAIN
    sim, speed = done("dam-break", there, **changes)
    return (sim.time,), speed


def settled(cell, wall):
    """Pressure after a dam break, 8 to 10 s, over that of the water above, and the floor's force.

    Of particles in the lowest quarter of a cell and in the lowest cell, more than 0.4 m from the
    ends; the force is over the weight.
    """
    seen = []

    def look(sim):
        if sim.time > 8.0 + 0.1 * len(seen):
            p = -sim.particles["stress"][:, :3].mean(axis=1)
            x, y = sim.particles["position"][:, :2].T
            middle, depth = np.abs(x - 1.62) < 1.2, 0.72 / 3.24
            ratio = p / (1000.0 * G * (depth - y))
            lowest = [ratio[middle & (y < part * cell)].mean() for part in (0.25, 1.0)]
            seen.append((*lowest, sim.diagnostics()["reaction.y-min-y"] / (720.0 * G)))

    changes = PLAIN | {
        "grid.size": [3.24, 2.40], "grid.cell": [cell, cell], "time.end": 10.0,
        "method.wall": wall, "output.every": None,
    }  # fmt: skip
    _, speed = done("dam-break", look, **changes)
    return tuple(np.mean(seen, axis=0).tolist()), speed


def blast(cell):
    """Velocity at which a plate flies that a wave in water has thrown, over Taylor's."""
    method = {"shape": "finite-gimp", "particles-per-cell": [2]}
    changes = {"grid.cell": [cell], "method": method, "time.step": {"courant": 0.3}}
    sim, speed = done("blast", **changes)
    line, q, theta = sim.diagnostics(), 1.5e6 * 1.0e-4 / 78.5, 1.0e-4
    exact = 2.0e6 * theta / 78.5 * q ** (-q / (q - 1.0))
    return (line["body.plate.momentum-x"] / line["body.plate.mass"] / exact,), speed


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
        "grid.cell": [cell, cell], "method.volumetric": volumetric, "method.affine": False,
        "bodies.strip.region.box.max": [half, 3.0],
        "bodies.strip.rigid.velocity.table": [[0.0, [0.0, 0.0]], [0.1, [0.0, -0.4 * cell]]],
    }  # fmt: skip
    times, force = np.linspace(0.35, 0.5, 31), reading("rigid.strip.force-y")
    forces, speed, _ = looked(CASES / "footing.yaml", times, force, changes)
    return (float(np.mean(forces[1:])) / (half * 1.0e4),), speed


def rankine(cell, way, dilation=30.0):
    """Thrust of sand on a smooth wall that recedes or advances, over that of a fluid: K_a, K_p.

    The floor is smooth as well, so that all of the sand yields; `way` is the wall's velocity. With
    a dilation of 30 degrees flow is along the normal, for which the exact values are.
    """
    law = {
        "model": "mohr-coulomb", "young": 1.0e4, "poisson": 0.3, "density": 1.0,
        "cohesion": 0.0, "friction-angle": 30.0, "dilation-angle": dilation,
    }  # fmt: skip
    recedes = {"velocity": {"table": [[0.5, [0.0, 0.0]], [0.6, [way, 0.0]]]}}
    bodies = {
        "fill": {"material": "sand", "region": box([0.0, 0.0], [2.0, 1.0])},
        "wall": {"rigid": recedes, "region": box([2.0, -0.5], [2.8, 2.0])},
    }
    case = case_of(
        [2.4, 1.2], cell, {"sand": law}, bodies, 2.0, method={"volumetric": "b-bar"},
        gravity={"table": [[0.0, [0.0, 0.0]], [0.5, [0.0, -1.0]]]},
        contact=[{"bodies": ["fill", "wall"]}], boundaries={"x-min": "slip", "y-min": "slip"},
    )  # fmt: skip
    thrusts, speed, _ = looked(case, np.linspace(1.5, 2.0, 51), reading("rigid.wall.force-x"))
    return (float(np.mean(thrusts[1:])) / 0.5,), speed


def undrained(steps, strain):
    """Deviator q of clay compressed at constant volume, at the end, over the pressure before."""
    clay = {
        "model": "cam-clay", "density": 1.0, "m": 1.2, "lambda": 0.2, "kappa": 0.04,
        "void-ratio": 1.0, "shear": 2.0e3, "preconsolidation": 100.0, "pressure": 100.0,
    }  # fmt: skip
    e = strain * np.arange(1, steps + 1) / steps
    F = np.array([np.diag(np.exp([-x, x, 0.0])) for x in e])
    s = pgimp.element(clay, F)["stress"][-1]
    return (float(np.sqrt(3.0) * 0.5 * (s[1] - s[0]) / 100.0),), None
