"""What is measured of each method; a number is None where the run fails."""

from itertools import pairwise
from math import pi

import numpy as np
from studies.method.bodies import bounce, cantilever, column, large, spin, wave
from studies.scenes import by_turns, finished

from pgimp.errors import RunError

COURANTS = (0.3, 0.1, 0.03)
COLUMN_CELLS = (1.0, 0.5, 0.25)


def _projected(sim, shape, component, times):
    """Times and motion along a mode, at about `times` instants until the end."""
    found = []
    every = sim.clock.end / times
    try:
        while not sim.finished:
            sim.advance()
            if sim.finished or sim.time >= len(found) * every:
                p, rows = sim.particles, sim.live()
                motion = shape[p.id[rows]] * p.v[rows, component]
                found.append((sim.time, p.m[rows] @ motion))
    except RunError:
        return None
    return np.array(found).T


def _rate(time, motion):
    """Angular frequency from the first and the last zero; None without two."""
    k = np.flatnonzero(motion[:-1] * motion[1:] < 0.0)
    if len(k) < 2:
        return None
    zeros = time[k] + (time[k + 1] - time[k]) * motion[k] / (motion[k] - motion[k + 1])
    return pi * (len(k) - 1) / (zeros[-1] - zeros[0])


def _lost(time, motion):
    """Part of a vibration's energy that is lost in a period, from its first and last peak.

    Each half swing but the first, which begins at its peak, and the last has one: that of the
    parabola through the three greatest values. Energies of a moment would not do: they swing by
    the angular frequency times half a step.
    """
    signs = np.flatnonzero(motion[:-1] * motion[1:] < 0.0) + 1
    peaks = []
    for low, high in pairwise(signs):
        k = low + int(np.argmax(np.abs(motion[low:high])))
        at = slice(max(k - 1, 0), k + 2)
        a, b, c = np.polyfit(time[at] - time[k], np.abs(motion[at]), 2)
        peaks.append(c - b * b / (4.0 * a))
    if len(peaks) < 2:
        return None
    return float(1.0 - (peaks[-1] / peaks[0]) ** (4.0 / (len(peaks) - 1)))


def bending(method, D, courants=COURANTS):
    """Frequency of a swinging beam over the exact one, less 1; energy lost in a period."""
    result = {}
    for courant in courants:
        sim, shape, exact = cantilever(method, D, courant)
        series = _projected(sim, shape, 1, 500)
        found = None if series is None else _rate(*series)
        if courant == COURANTS[0]:
            result["frequency"] = None if found is None else found / exact - 1.0
        result[f"swing {courant}"] = None if series is None else _lost(*series)
    return result


def waves(method):
    """Speed of waves of ten cells over the exact one, less 1; energy lost in a period."""
    result = {}
    for courant in COURANTS:
        sim, shape, exact = wave(method, courant)
        series = _projected(sim, shape, 0, 240)
        if courant == COURANTS[-1]:  # without what the length of the step adds
            result["speed"] = None if series is None else _rate(*series) / exact - 1.0
        result[f"wave {courant}"] = None if series is None else _lost(*series)
    return result


def bounced(method, D):
    """Part of the energy that a block has lost when it is back where it came from."""
    sim = bounce(method, D)
    first = sim.diagnostics()
    try:
        while not sim.finished:
            for _ in range(10):
                sim.advance()
            line = sim.diagnostics()
            if line["body.body.momentum-y"] > 0.0 and (
                line["body.body.centre-y"] >= first["body.body.centre-y"]
            ):
                return {"bounce": line["dissipated-energy"] / first["kinetic-energy"]}
    except RunError:
        pass
    return {"bounce": None}


def turned(method, D, courants=COURANTS):
    """Part of the spin that a block has lost after a turn."""
    names = ["angular-momentum-z"] if D == 2 else [f"angular-momentum-{c}" for c in "xyz"]
    result = {}
    for courant in courants:
        sim = spin(method, D, courant)
        first = np.array([sim.diagnostics()[name] for name in names])
        result[f"spin {courant}"] = None
        if _came_to_the_end(sim):
            last = np.array([sim.diagnostics()[name] for name in names])
            result[f"spin {courant}"] = float(1.0 - last @ first / (first @ first))
    return result


def _came_to_the_end(sim):
    """Run to the end; whether it came there."""
    try:
        finished(sim)
    except RunError:
        return False
    return True


def compressed(method):
    """Mean difference of a column's stress from the exact one over the weight, by cell."""
    result = {}
    for cell in COLUMN_CELLS:
        sim, exact = column(method, cell)
        result[f"column {cell}"] = None
        if not _came_to_the_end(sim):
            continue
        p, rows = sim.particles, sim.live()
        difference = np.abs(p.sigma[rows, 1] - exact[p.id[rows]])
        result[f"column {cell}"] = float(difference.mean() / np.abs(exact).max())
    return result


def costs(methods, D, rounds=4, steps=12):
    """CPU seconds of a step of a large block by method: the least of rounds taken by turns."""
    least = by_turns([large(method, D) for method in methods], rounds, steps).min(axis=0)
    return dict(zip(methods, least.tolist(), strict=True))
