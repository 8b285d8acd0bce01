"""Further problems with known answers, the errors of their runs."""

import re
from math import log, pi, sqrt

import numpy as np
from studies.auto import scenes
from studies.auto.problem import METHODS, Problem


def _late(run, column, part=0.2):
    """Mean of a column over the last part of a run."""
    history = run.history
    return float(history[column][history["time"] > (1.0 - part) * history["time"][-1]].mean())


def _elastica(run):
    """Deflection of the tip, P L^2/(E I) = 2 (K. Mattiasson, 1981)."""
    probe = run.probes["tip"]
    return abs(-probe["displacement-y"][-10:].mean() / (0.49346 * 8.0) - 1.0)


def _torsion(run):
    """Torque of a square bar: 1.006 of Saint-Venant's, 0.1406 G a^4 by the twist a length.

    The grips hinder its warping; see `studies.auto.twisted_bar`.
    """
    exact = 1.006 * 0.140577 * 1000.0 * 0.1 / 3.0
    return abs(abs(_late(run, "torque.turns-x", 0.3)) / exact - 1.0)


def frequency(run, column, exact):
    """Error of the angular frequency with which a column swings, by the best fit of a wave."""
    time, value = run.history["time"], run.history[column]
    late = time > 0.05 * time[-1]
    tried = exact * np.linspace(0.8, 1.2, 4001)

    def rest(w):
        waves = np.stack([np.sin(w * time), np.cos(w * time), np.ones_like(time)], axis=1)[late]
        return np.linalg.lstsq(waves, value[late], rcond=None)[1].sum()

    return abs(float(tried[np.argmin([rest(w) for w in tried])]) / exact - 1.0)


def _kirsch(run):
    """Ways of the wall at crown and springline."""
    worst = 0.0
    for name, side in (("crown", -1.0), ("springline", 1.0)):
        probe = run.probes[name]
        x, y = probe["position-x"][0], probe["position-y"][0]
        k, turn = 4.0 / (x * x + y * y), side * abs(np.cos(2.0 * np.arctan2(y, x)))
        exact = 2.0 * sqrt(k) * 1.3e-3 * (0.75 - 0.25 * turn * (2.8 - k))
        way = np.hypot(probe["displacement-x"][-1], probe["displacement-y"][-1])
        worst = max(worst, abs(way / exact - 1.0))
    return float(worst)


def _brazilian(run):
    """Both stresses in the middle by the force, 2 P/(pi D) and three times that."""
    force, middle = 2.0 * abs(_late(run, "rigid.plate.force-y")), run.probes["middle"]
    found = [middle[f"stress-{c}"][-16:].mean() * pi / force for c in ("xx", "yy")]
    return float(max(abs(found[0] - 1.0), abs(found[1] / 3.0 + 1.0)))


def _sphere(run):
    """Displacement between the surfaces (Lame)."""
    probe = run.probes["half"]
    x, y = probe["position-x"][0], probe["position-y"][0]
    r = np.hypot(x, y)
    exact = 5.0 * r / 7000.0 * (0.4 + 1.3 * 8.0 / (2.0 * r**3))
    way = (probe["displacement-x"] * x + probe["displacement-y"] * y)[-20:].mean() / r
    return abs(way / exact - 1.0)


def _float(run):
    """Draught, of a block half as heavy as water; water keeps its area, 0.48 less the hole."""
    centre = _late(run, "body.block.centre-y", 0.4)
    draught = 0.48 - 0.36 * 0.08 + 0.36 * 0.1 - (centre - 0.1)
    return abs(draught / 0.1 - 1.0)


def _wall(run):
    """Rankine's passive force, gamma H^2/2 + 2 c H, on a wall that has moved."""
    history = run.history
    way = history["rigid.wall.displacement-x"]
    late = way > 0.02
    high = 1.0 + way[late].mean() / 5.0
    return abs(-history["rigid.wall.force-x"][late].mean() / (0.5 * high**2 + 2.0 * high) - 1.0)


def _poiseuille(run):
    """Velocity of the profile that sets in, of its greatest in the end."""
    frame, g, high, nu = run.frame(-1), 9.81, 0.1, 0.1**2 * 9.81 / (8.0 * 0.495227)
    y, n = frame["position"][:, 1], np.arange(1, 40, 2)[:, None]
    odd = 4.0 * g * high**2 / (nu * pi**3 * n**3) * np.sin(n * pi * y / high)
    fades = np.exp(-(n**2) * pi**2 * nu * frame.time / high**2)
    exact = g * y * (high - y) / (2.0 * nu) - (odd * fades).sum(axis=0)
    off = np.abs(frame["velocity"][:, 0]) - exact
    return float(np.sqrt(np.mean(off**2)) / 0.495227)


def _bagnold(run):
    frame = run.frame(-1)
    y, v = frame["position"][:, 1], frame["velocity"][:, 0]
    return float(np.sqrt(np.mean((v / 0.5778 - (1.0 - (1.0 - y / 0.04) ** 1.5)) ** 2)))


def _cavity(run):
    """Pressure in the cavity, over its growth."""
    history = run.history
    a = 1.0 + history["displacement.push-x"]
    pressure, wide = history["constraint.push-x"] / (2.0 * pi * a * 0.25), a > 1.2
    square = 50.0 * (a[wide] ** 2 - 1.0)
    part = pressure[wide] / (1.0 + np.log(square / a[wide] ** 2) - square / 900.0)
    return abs(part.mean() - 1.0)


def _thick_tube(run):
    """Pressure that the tube bears when all of it yields."""
    first = run.frame(0)
    start = np.hypot(*first["position"].T)
    deep = (first["body"] == 1) & (start < 0.8) & (first["position"][:, 1] > 0.6)
    found = [run.frame(n)["pressure"][deep].mean() for n in range(len(run) - 5, len(run))]
    return abs(np.mean(found) / 0.7935 - 1.0)


def _graded(run):
    probe = run.probes["surface"]
    late = probe["time"] > 10.2
    x = probe["position-x"][0]
    exact = (-9.81 * 2000.0 / 4.0e6) * (x - 5.0 * log(100.0 / (20.0 + 4.0 * (20.0 - x))))
    return abs(probe["displacement-x"][late].mean() / exact - 1.0)


def _hertz_line(run):
    """Approach that belongs to the force."""
    history, plane = run.history, 1.0e6 / 0.91
    force = 2.0 * np.abs(history["reaction.y-min-y"][history["time"] > 0.065]).mean()
    wide = sqrt(4.0 * force * 0.1 / (pi * plane))
    return abs(2.0 * force / (pi * plane) * (2.0 * log(0.4 / wide) - 1.0) / 3.6e-3 - 1.0)


def _heap(run, exact):
    """Run-out of a column of sand over its width (G. Lube et al., 2005)."""
    x, area, half = run.frame(-1)["position"][:, 0], 0.05**2 / 4.0, 0.25 * 0.05
    places = np.arange(0.05, x.max() + 0.1, 0.005)
    low, high = places[:, None] - 0.05, places[:, None] + 0.05
    wide = np.clip(np.minimum(high, x + half) - np.maximum(low, x - half), 0.0, None).sum(axis=1)
    front = places[np.argmax(wide * area / (2.0 * half * 0.1) < 0.05)]
    return abs((front - 1.0) / exact - 1.0)


def _safety(text):
    """Error of the factor of safety, half a step below the one with which the slope slides."""
    slid = re.search(r"'f(\d+)'", text)
    return abs(0.01 * (int(slid[1]) - 1) / 1.38 - 1.0) if slid else 1.0


SOLID = (
    "gimp",
    "gimp, affine",
    "gimp, affine, mean",
    "finite-gimp, affine",
    "cpdi, affine",
    "bspline-quadratic, affine",
    "initial",
    "initial, averaged",
    "initial, mean",
    "initial, 3 a cell",
    "initial, bspline-quadratic",
)
DEAR = ("gimp", "gimp, affine", "gimp, affine, mean", "initial", "initial, mean")
CURRENT = tuple(name for name in METHODS if not name.startswith("initial"))
FLOWS = (
    "gimp",
    "gimp, affine",
    "finite-gimp, affine",
    "cpdi, affine",
    "bspline-quadratic, affine",
    "gimp, affine, 3 a cell",
)
PLASTIC = (
    "gimp",
    "gimp, affine",
    "gimp, mean",
    "gimp, affine, mean",
    "finite-gimp, affine, mean",
    "initial, mean",
)

#: Factors of strength, of which the slope slides with one of the last.
_FACTORS = range(130, 152, 2)

MORE = {
    "elastica": Problem("", "deflection", scenes.BENT, _elastica, DEAR),
    "torsion": Problem("", "torque", scenes.TWISTED, _torsion),
    "frequency of a beam": Problem(
        "", "frequency", scenes.SWINGING,
        lambda run: frequency(run, "momentum-y", scenes.BEAM), DEAR,
    ),
    "Kirsch": Problem("tunnel", "ways of the wall", {"grid.cell": [0.5, 0.5]}, _kirsch, SOLID),
    "Brazilian disk": Problem("", "stresses", scenes.CRUSHED, _brazilian, DEAR),
    "thick sphere": Problem("", "displacement", scenes.SPHERE, _sphere),
    "sloshing": Problem(
        "", "frequency", scenes.SLOSHES,
        lambda run: frequency(run, "momentum-x", scenes.SLOSHING), FLOWS,
    ),
    "float": Problem("", "draught", scenes.FLOATS, _float, ("gimp", "gimp, affine")),
    "passive wall": Problem("", "force (Rankine)", scenes.PUSHED, _wall, PLASTIC),
    "Poiseuille": Problem("poiseuille", "velocity", {}, _poiseuille, CURRENT),
    "Bagnold": Problem("bagnold", "velocity", {"time.end": 2.0}, _bagnold, ("gimp", *FLOWS[1:])),
    "cavity": Problem("cavity", "pressure (Hill)", {"grid.cell": [0.5, 0.5],
                      "grid.size": [32.0, 0.5]}, _cavity, PLASTIC),
    "thick tube": Problem("thick-tube", "pressure (Hill)", {}, _thick_tube, PLASTIC),
    "graded ground": Problem(
        "graded", "settlement", {"grid.cell": [1.0], "accuracy": None}, _graded
    ),
    "line contact (Hertz)": Problem(
        "hertz-line", "approach", {"grid.cell": [4.8e-3] * 2}, _hertz_line, SOLID
    ),
    # 1.2 of the height over the width below 1.8 widths, 1.9 of its power 2/3 above 2.8.
    "heap": Problem("", "run-out (Lube)", scenes.HEAP, lambda run: _heap(run, 1.2), CURRENT),
    "sand column": Problem(
        "", "run-out (Lube)", scenes.TALL, lambda run: _heap(run, 1.9 * 3.0 ** (2 / 3)), CURRENT
    ),
    "slope stability": Problem(
        "safety", "factor of safety",
        {"grid.cell": [1.25] * 2, "time.stages": [
            {"name": f"f{factor}", "strength-reduction": {"factor": 0.01 * factor},
             "equilibrate": {"tolerance": 1.0e-4, "steps": 1000}} for factor in _FACTORS
        ]},
        lambda run: 0.01 * _FACTORS[-1] / 1.38 - 1.0, CURRENT, _safety,
    ),
}  # fmt: skip
