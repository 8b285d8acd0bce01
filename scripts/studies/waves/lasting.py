"""Bodies with averaged mass that move, or rest, for 100,000 steps: what of their books drifts."""

import numpy as np
from studies.scenes import box, case_of, core

from pgimp.kernels.data.motion import KEPT_MASS, KEPT_VELOCITY

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
SPEED = float(np.sqrt(100.0 * 0.7 / (1.3 * 0.4)))
WEIGHT = 0.02
SCENES = {
    "a block that turns and bends": "turning",
    "a cantilever that swings": "cantilever",
    "a pile of three blocks": "pile",
}


def _case(name, mass, courant):
    def body(low, size, **more):
        region = box(low, np.add(low, size))
        return {"material": "soft", "configuration": "initial", "region": region} | more

    size, parts = [24.0, 16.0], {"method": {"mass": mass}}
    if name == "turning":
        spin = {"rotation": {"about": [11.37, 7.21], "rate": 0.02 * SPEED}}
        bodies = {"block": body([3.37, 3.21], [16, 8], velocity=spin)}
    elif name == "cantilever":
        bodies = {"beam": body([0.0, 6.21], [16, 4])}
        parts["boundaries"] = {"x-min": "fixed"}
    else:
        bodies = {f"b{n}": body([5.37 + 0.6 * n, 5.0 * n], [8 - n, 5]) for n in range(3)}
        parts |= {
            "boundaries": {"y-min": "fixed"}, "contact": [{"bodies": "all", "friction": 0.3}],
            "gravity": [0.0, -WEIGHT], "start": {"settle": {"tolerance": 1e-6}},
        }  # fmt: skip
    return case_of(size, 1.0, {"soft": SOFT}, bodies, 1e9, courant=courant, **parts)


def _bend(sim, held):
    """Add velocities of bending, those of a free block without momentum."""
    grid, frame = sim.rank.grid, sim.scene.domain.frame
    values = grid.by_vertex(grid.kept.values)[:, 0, :, 0]
    m = values[..., KEPT_MASS]
    x = (np.arange(len(m)) + grid.window.lower[0] - frame.ghost)[:, None] * np.ones_like(m)
    wave = np.pi * (x - 11.37) / 16.0
    shapes = (0.0 * x, (x / 16.0) ** 2) if held else (np.sin(wave), -0.5 * np.cos(wave))
    for d, v in enumerate(shapes):
        add = 0.05 * SPEED * v * (m > 0.0)
        if not held:
            add -= (m > 0.0) * (add * m).sum() / m.sum()
        values[..., KEPT_VELOCITY + d] += add
    sim.rank.population.outdate(True)


def books(name, mass, courant, steps):
    """Greatest changes of energy, of spin, and of momentum less impulses, over its scale; drift.

    The drift is the mean energy of the last tenth less that of the first. Velocities are half a
    step behind, so that kinetic energy is a mean over two steps. Scales are the energy, the spin at
    the start, and mass times the wave speed; of the pile its strain energy.
    """
    sim, found, push = core(_case(name, mass, courant)), [], np.zeros(2)
    while sim.scene.domain.settling:
        sim.advance()
    if name != "pile":
        _bend(sim, name == "cantilever")
    first = sim.diagnostics()
    last, before, face = first, first, {"cantilever": "x-min", "pile": "y-min"}.get(name)
    for n in range(steps + 1):
        sim.advance()
        if n % 250 > 1:
            continue
        line = sim.diagnostics()
        if face:
            push += (line["time"] - last["time"]) * np.array(
                [line[f"reaction.{face}-{a}"] for a in "xy"]
            )
        last = line
        if n % 250 == 1:
            kinetic = 0.5 * (before["kinetic-energy"] + line["kinetic-energy"])
            gain = np.array([line[f"momentum-{a}"] - first[f"momentum-{a}"] for a in "xy"])
            if name == "pile":
                push_all = push - [0.0, line["mass"] * WEIGHT * (line["time"] - first["time"])]
            else:
                push_all = push
            found.append([
                kinetic + line["strain-energy"], line["angular-momentum-z"],
                np.abs(gain - push_all).max() / (line["mass"] * SPEED), kinetic,
            ])  # fmt: skip
        before = line
    found = np.array(found)
    energy, spin = found[:, 0], found[:, 1]
    tenth = len(found) // 10
    return {
        "energy": np.abs(energy / energy[0] - 1.0).max(),
        "drift": energy[-tenth:].mean() / energy[:tenth].mean() - 1.0,
        "spin": np.abs(spin / spin[0] - 1.0).max() if name == "turning" else None,
        "momentum": found[:, 2].max(),
        "kinetic": (found[:, 3] / energy).max(),
    }
