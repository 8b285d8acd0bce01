"""Problems with known answers: cases, or parts of them, and the relative error of a run."""

from collections.abc import Callable
from typing import Any

import numpy as np
from studies.auto.more import CURRENT, DEAR, FLOWS, MORE, PLASTIC, SOLID
from studies.auto.problem import Problem


def _last(run: Any, column: str) -> float:
    return float(run.history[column][-1])


def _bar(run):
    """Period and energy of the vibrating bar."""
    history = run.history
    time, momentum = history["time"], history["momentum-x"]
    at = np.flatnonzero(momentum[1:-1] * momentum[2:] < 0.0) + 1
    crossings = time[at] + momentum[at] / (momentum[at] - momentum[at + 1]) * np.diff(time)[at]
    period = abs(crossings[-1] / (0.1 * len(crossings)) - 1.0)
    kept = history["kinetic-energy"] + history["strain-energy"] - history["external-work"]
    return max(period, np.abs(kept).max() / history["external-work"].max())


def _column(run):
    """Stress under its own weight."""
    return float(run.history["error"][-1])


def _error(column: str) -> Callable[[Any], float]:
    return lambda run: float(np.nanmax(run.history[column]))


def _energy(run):
    """Energy lost, of that of the fall."""
    history = run.history
    total = history["kinetic-energy"] + history["strain-energy"] - history["external-work"]
    return float(np.abs(total - total[0]).max() / history["external-work"].max())


def _cradle(run):
    """Speed of the struck body over that of the other, waves and all else being lost."""
    history = run.history
    kept = history["kinetic-energy"] + history["strain-energy"]
    return float(1.0 - kept[-1] / kept[0])


def _spin(run):
    history = run.history
    spin = history["angular-momentum-z"]
    return float(np.abs(spin / spin[0] - 1.0).max())


def _incline(run):
    """Mean acceleration, by the best line: the block hops a little, and friction with it."""
    history = run.history
    late, speed = history["time"] > 0.25, history["momentum-x"] / history["mass"]
    return abs(float(np.polyfit(history["time"][late], speed[late], 1)[0]) / 1.3015 - 1.0)


def _rolling(run):
    history = run.history
    speed = history["body.cylinder.momentum-x"] / history["body.cylinder.mass"]
    return abs(speed[history["time"] > 0.4].mean() - 1.0)


def _upsetting(run):
    """Force of the punch against finite elements: see `studies.auto.pressed_bar`."""
    history = run.history
    holds = (history["time"] > 0.3) & (history["time"] < 0.4)
    return abs(history["rigid.punch.force-y"][holds].mean() / 43910.0 - 1.0)


def _footing(run):
    history = run.history
    down = -history["rigid.strip.displacement-y"]
    late = (down > 0.012) & (down < 0.016)
    return abs(history["rigid.strip.force-y"][late].mean() / 1.05e4 / (2.0 + np.pi) - 1.0)


def _tube(run):
    frame, pressure = run.frame(-1), 6.283185307e7
    r = frame["position"][:, 0] - frame["displacement"][:, 0]
    young, poisson, part = 1.661538461538e11, 0.03846153846154, pressure / 3.0
    exact = part * (1 + poisson) / young * ((1 - 2 * poisson) * r + 1.0 / r)
    return float(np.abs(frame["displacement"][:, 0] / exact - 1.0).max())


def _sod(run):
    frame, t, worst = run.frame(-1), 0.2, 0.0
    x, u = frame["position"][:, 0], frame["velocity"][:, 0]
    contact, shock = 0.927453 * t, 1.752156 * t
    tail = contact - t * np.sqrt(1.4 * 0.303130 / 0.426319)
    for low, high, density in ((tail, contact, 0.426319), (contact, shock, 0.265574)):
        inside = np.abs(x - 0.5 * (low + high)) < 0.3 * (high - low)
        found = frame["pressure"][inside].mean(), u[inside].mean(), frame["density"][inside].mean()
        parts = np.array(found) / (0.303130, 0.927453, density) - 1.0
        worst = max(worst, np.abs(parts).max())
    return float(worst)


def _taylor(run):
    """Length and radius, outside of what was published."""
    frame = run.frame(-1)
    x = frame["position"]
    length = (x[:, 1] + frame["radius"]).max() * 1e3
    wide = (x[:, 0] + frame["radius"])[x[:, 1] < 2e-3].max() * 1e3
    off = [max(0.0, a - v, v - b) / a for v, a, b in ((length, 21.4, 21.7), (wide, 6.9, 7.2))]
    return max(off)


def _dam(run):
    """Level and weight of what has come to rest, and mass kept: here the time of the front."""
    history = run.history
    first = history["time"][np.flatnonzero(-history["reaction.x-max-x"] > 10.0)[0]]
    return abs(first / 0.584 - 1.0)


def _still(run):
    """Pressure in still water, rms over the greatest."""
    frame = run.frame(-1)
    y = frame["position"][:, 1]
    exact = 1000.0 * 9.81 * (0.6 - y)
    return float(np.sqrt(np.mean((frame["pressure"] - exact) ** 2)) / (9810.0 * 0.6))


def _plates(run):
    frame = run.frame(-1)
    x, p = frame["position"][:, 0], -frame["stress"][:, 0]
    between = (np.abs(x) > 0.0128) & (np.abs(x) < 0.0144)
    found = p[np.abs(x) < 0.009].mean() / 1053.5e6, p[between].mean() / 700.0e6
    return float(np.abs(np.array(found) - 1.0).max())


def _blast(run):
    return abs(_last(run, "body.plate.momentum-x") / _last(run, "body.plate.mass") / 0.655 - 1.0)


def _poiseuille(run):
    return float(run.history["error"][-1])


def _beam(run):
    """Deflection against quadratic finite elements, see `studies.hard.cantilever`."""
    from studies.hard.cantilever import mean_deflection

    exact = mean_deflection(1.0, 0.499, 2.0, 1.0, -5.0e-4, (32, 16))
    history = run.history
    late = history["time"] > 56.0
    way = (history["body.beam.centre-y"] - history["body.beam.centre-y"][0])[late].mean()
    return abs(way / exact - 1.0)


def _stretch(run):
    """Spacing of neighbours over that by their F: torn where these differ."""
    frame = run.frame(-1)
    x = frame["position"][:, 0]
    F = frame["deformation"].reshape(len(x), -1)[:, 0]
    grown = 0.5 * (F[1:] + F[:-1]) * 42.0 / len(x)
    return float(np.abs(np.diff(x) / grown - 1.0).max())


def _dzhanibekov(run):
    """Angular momentum kept, and energy of the turning."""
    history = run.history
    L = np.sqrt(sum(history[f"angular-momentum-{a}"] ** 2 for a in "xyz"))
    kept = history["kinetic-energy"] + history["strain-energy"]
    return float(max(np.abs(L / L[0] - 1.0).max(), abs(kept[-1] / kept[0] - 1.0)))


RUBBER = {"model": "neo-hookean", "young": 1.0e3, "poisson": 0.3, "density": 1.0}
#: A block with three different sides about its middle axis, disturbed a little.
TURNING = {
    "format": 1, "title": "Dzhanibekov", "dimensions": 3,
    "grid": {"size": [2.4, 2.4, 2.4], "cell": [0.1, 0.1, 0.1]},
    "time": {"end": 8.0}, "materials": {"rubber": RUBBER},
    "bodies": {"block": {
        "material": "rubber", "region": {"box": {"min": [0.7, 0.9, 1.0], "max": [1.7, 1.5, 1.4]}},
        "velocity": {"rotation": {"about": [1.2, 1.2, 1.2], "rate": [0.02, 2.0, 0.0]}},
    }},
    "history": {"every": 0.05},
}  # fmt: skip
#: Two bars of 20 cells, one of which hits the other.
BARS = {
    "format": 1, "title": "Cradle", "dimensions": 1,
    "grid": {"size": [80.0], "cell": [1.0]}, "time": {"end": 0.2},
    "materials": {"bar": {"model": "linear-1d", "young": 1.0e6, "density": 1.0}},
    "bodies": {
        "a": {"material": "bar", "region": {"box": {"min": [5.0], "max": [25.0]}},
              "velocity": [10.0]},
        "b": {"material": "bar", "region": {"box": {"min": [26.0], "max": [46.0]}}},
    },
    "history": {"every": 0.002},
}  # fmt: skip
#: Contact of the bar with die and punch without friction, as in the finite elements.
SMOOTH = [{"bodies": ["bar", "die"]}, {"bodies": ["bar", "punch"]}]
STILL = {"bodies.dam.region.box": {"min": [0.0, 0.0], "max": [1.0, 0.6]},
         "grid.size": [1.0, 0.8], "grid.cell": [0.05, 0.05], "time.end": 2.0}  # fmt: skip


def _bars(run):
    """Speed of the bar that was hit, over that of the other before."""
    history = run.history
    return abs(history["body.b.momentum-x"][-1] / (10.0 * history["body.b.mass"][-1]) - 1.0)


PROBLEMS = {
    "bar that vibrates": Problem(
        "bar-vibration", "period, energy", {"grid.cell": [0.05], "grid.size": [1.1]}, _bar
    ),
    "compacted column": Problem("compaction", "stress (42)", {"time.end": 0.5}, _column),
    "plane waves": Problem(
        "plane-waves", "displacement", {"grid.cell": [0.03125] * 2}, _error("error.displacement-l2")
    ),
    "step of stress": Problem("shock", "stress", {"grid.cell": [1.0]}, _error("error")),
    "vortex": Problem(
        "vortex", "displacement", {"grid.cell": [0.1, 0.1]}, _error("error.displacement-l2")
    ),
    "spinning block": Problem(
        "spinning-block",
        "displacement",
        {"grid.cell": [0.2] * 3, "time.end": 0.5},
        _error("error.displacement-l2"),
    ),
    "a square turns": Problem("hard/spinning", "spin", {"time.end": 251.3274122871834}, _spin),
    "Dzhanibekov": Problem("", "spin and energy", TURNING, _dzhanibekov, DEAR),
    "bounce": Problem(
        "block3d", "energy", {"grid.cell": [0.1] * 3, "time.end": 0.8}, _energy, DEAR
    ),
    "cradle": Problem("", "speed passed on", BARS, _bars),
    "disks": Problem("disks", "energy", {}, _cradle, SOLID),
    "slope": Problem("incline", "acceleration", {}, _incline, SOLID),
    "rolling": Problem("rolling", "speed", {"grid.cell": [0.05, 0.05]}, _rolling, SOLID),
    "upsetting": Problem(
        "upsetting",
        "force",
        {"grid.cell": [0.05, 0.05], "time.end": 0.4, "contact": SMOOTH},
        _upsetting,
        DEAR,
    ),
    "cantilever of 0.499": Problem("hard/bending", "deflection", {"time.end": 112.0}, _beam, DEAR),
    "stretch to 3": Problem("hard/stretch", "evenness of F", {"time.end": 6.0}, _stretch),
    "tube (Lame)": Problem("tube", "displacement", {}, _tube),
    "Taylor's bar": Problem("taylor-axisymmetric", "length, radius", {}, _taylor),
    "plates": Problem("plate-impact", "stresses", {}, _plates),
    "footing": Problem("footing", "bearing capacity", {}, _footing, PLASTIC),
    "still water": Problem("dam-break", "pressure", STILL, _still, CURRENT),
    "dam break": Problem(
        "dam-break",
        "time of the front",
        {"grid.size": [3.2, 2.4], "grid.cell": [0.04, 0.04], "time.end": 0.8},
        _dam,
        CURRENT,
    ),
    "Sod's tube": Problem("sod", "plateaus", {"grid.cell": [0.005]}, _sod),
    "plate on water": Problem("blast", "velocity", {}, _blast, FLOWS),
    **MORE,
}
