"""A pulse and a front along a free bar, against d'Alembert's solution."""

import numpy as np
from drawing.common import plt, save
from studies.scenes import case_of, core, filled

from pgimp.kernels.data.motion import KEPT_VELOCITY

#: Cells of the bar and of the pulse, and ways along the bar after which it is looked at.
CELLS, WIDTH, WAYS = 200, 20, (2, 10)
COURANT = 0.3


def _pulse(x):
    """Velocity at the start, of height 1 at the middle: two halves part, and meet there again."""
    s = (x - 0.5 * CELLS) / WIDTH
    return np.where(np.abs(s) < 0.5, np.cos(np.pi * s) ** 2, 0.0)


def _step(x):
    """Velocity at the start of one half: a front parts to both sides, each half as high."""
    return np.where(x < 0.5 * CELLS, 1.0, 0.0)


def run(mass, begin=_pulse, all_ways=WAYS):
    """Coordinates of the vertices, and their velocities after each number of ways."""
    body = {"material": "bar", "formulation": "total-lagrangian"} | filled([4.0], [4.0 + CELLS])
    law = {"model": "linear-1d", "young": 1.0, "density": 1.0}
    case = case_of([CELLS + 8.0], 1.0, {"bar": law}, {"bar": body}, 1.0,
                   method={"mass": mass})  # fmt: skip
    case["time"] = {"end": COURANT * 1e5, "step": COURANT}
    sim = core(case)
    grid, small = sim.rank.grid, 1e-4
    values = grid.by_vertex(grid.kept.values)[:, 0, 0, 0]
    x = np.arange(len(values)) + grid.window.lower[0] - sim.scene.domain.frame.ghost - 4.0
    inside = (x >= 0.0) & (x <= CELLS)
    values[:, KEPT_VELOCITY] = small * begin(x) * inside
    found = {}
    for ways in all_ways:
        while sim.step < round(ways * CELLS / COURANT):
            sim.advance()
        late = ways * CELLS - (sim.step - 0.5) * COURANT
        exact = 0.5 * (begin(x[inside] - late) + begin(x[inside] + late))
        values = grid.by_vertex(grid.kept.values)[:, 0, 0, 0]
        found[ways] = values[inside, KEPT_VELOCITY] / small, exact
    return x[inside], found


def rows():
    """Rows of the table; draws the picture."""
    figure, axes = plt.subplots(1, len(WAYS), figsize=(9.0, 3.0), sharey=True, layout="tight")
    for mass, colour in (("lumped", "tab:red"), ("averaged", "tab:blue")):
        x, found = run(mass)
        for axis, ways in zip(axes, WAYS, strict=True):
            v, exact = found[ways]
            if mass == "lumped":
                axis.plot(x, exact, color="0.7", linewidth=4.0, label="d'Alembert")
            axis.plot(x, v, color=colour, linewidth=1.2, label=mass)
            axis.set(xlim=(60, 140), xlabel="place, in cells", title=f"after {ways} lengths")
        v, exact = found[WAYS[-1]]
        error = np.sqrt(((v - exact) ** 2).sum() / (exact**2).sum())
        yield [mass, f"{100.0 * error:.1f} %", f"{v.max():.3f}"]
    axes[0].set_ylabel("velocity")
    axes[0].legend(frameon=False)
    save(figure, "waves-pulse")


def front(mass):
    """Cells in which the velocity rises from 0.1 to 0.9 of a front, after 10 ways; overshoot.

    Fronts are at a quarter and at three quarters of the bar then.
    """
    x, found = run(mass, _step, (WAYS[-1] + 0.25,))
    v, _ = found[WAYS[-1] + 0.25]
    behind = x > 0.5 * CELLS
    x, v = x[behind], 2.0 * v[behind]  # from 1 to 0
    ends = []
    for level in (0.9, 0.1):  # the last one above 0.9, the first one below 0.1
        i = np.flatnonzero(v > level)[-1] if level > 0.5 else np.flatnonzero(v < level)[0] - 1
        ends.append(x[i] + (v[i] - level) / (v[i] - v[i + 1]))
    return ends[1] - ends[0], v.max() - 1.0


def front_rows():
    """Rows of the table of fronts."""
    for mass in ("lumped", "averaged"):
        width, over = front(mass)
        yield [mass, f"{width:.1f}", f"{100.0 * over:.0f} %"]
