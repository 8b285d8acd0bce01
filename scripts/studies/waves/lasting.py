"""Bodies with averaged mass that move, or rest, for 100,000 steps: what of their books drifts."""

import numpy as np
from studies.scenes import box, case_of, core

from pgimp.kernels.data.motion import KEPT_MASS, KEPT_VELOCITY

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
SPEED = float(np.sqrt(100.0 * 0.7 / (1.3 * 0.4)))
WEIGHT = 0.02
#: Steps from one look to the next.
_EVERY = 250
SCENES = {
    "a block that turns and bends": "turning",
    "a cantilever that swings": "cantilever",
    "a pile of three blocks": "pile",
}


def _case(name, mass, courant):
    def body(low, size, **more):
        region = box(low, np.add(low, size))
        return {"material": "soft", "formulation": "total-lagrangian", "region": region} | more

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
            "gravity": [0.0, -WEIGHT], "start": {"equilibrate": {"tolerance": 1e-6}},
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
    if sim.rank.slaves:
        sim.rank.slaves.spread(sim.rank, grid.kept.values, KEPT_VELOCITY)
    sim.rank.population.outdate(True)


def books(name, mass, courant, steps):
    """Changes of energy, of spin, and of momentum less impulses over mass times wave speed.

    They are the greatest ones, each over its value at the start; the energy's drift is its mean of
    the last tenth less that of the first. Velocities are half a step behind: kinetic energy is a
    mean over two steps. What is held, or rests, has no spin of its own.
    """
    sim, found, push = core(_case(name, mass, courant)), [], np.zeros(2)
    while sim.scene.domain.settling:
        sim.advance()
    if name != "pile":
        _bend(sim, name == "cantilever")
    first = last = sim.diagnostics()
    face = {"cantilever": "x-min", "pile": "y-min"}.get(name)
    for n in range(1, steps + 1):
        sim.advance()
        if n % _EVERY > 1:
            continue
        before, last = last, sim.diagnostics()
        if face:  # mean forces since the line before
            push += (last["time"] - before["time"]) * np.array(
                [last[f"reaction.{face}-{a}"] for a in "xy"]
            )
        if n % _EVERY == 1 and n > 1:
            kinetic = 0.5 * (before["kinetic-energy"] + last["kinetic-energy"])
            gain = np.array([last[f"momentum-{a}"] - first[f"momentum-{a}"] for a in "xy"]) - push
            if name == "pile":
                gain[1] += last["mass"] * WEIGHT * last["time"]
            found.append([
                kinetic + before["strain-energy"], last["angular-momentum-z"],
                np.abs(gain).max() / (last["mass"] * SPEED),
            ])  # fmt: skip
    energy, spin, momentum = np.array(found).T
    tenth = max(1, len(found) // 10)
    return {
        "energy": np.abs(energy / energy[0] - 1.0).max(),
        "drift": energy[-tenth:].mean() / energy[:tenth].mean() - 1.0,
        "spin": np.abs(spin / spin[0] - 1.0).max() if name == "turning" else None,
        "momentum": momentum.max(),
    }


def rows(steps):
    """Rows of the table."""
    for words, name in SCENES.items():
        for courant in (0.3, "auto"):
            for mass in ("lumped", "averaged"):
                found = books(name, mass, courant, steps).values()
                cells = ("" if each is None else f"{each:.0e}" for each in found)
                yield [words, f"`{courant}`", mass, *cells]
