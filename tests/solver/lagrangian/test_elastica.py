"""A cantilever bent to a full circle by the rotation of its end: Euler's elastica, and its exact
form for a strip of some height, the cylindrical bending of a block (Rivlin 1949).
"""

from time import perf_counter

import numpy as np
import pytest
from scenes import box, field, scene, start

pytestmark = pytest.mark.slow(60)

LENGTH, HEIGHT, E = 8.0, 0.5, 1000.0
#: Periods of the first mode, 22.4 sqrt(E H^2/12)/L^2 clamped at both ends, are 3.9 long.
BENDS, RESTS = 14.0, 10.0
#: Place of the clamp, and the height of the centre line.
ROOT, LINE = 1.0, 0.75


def bent(cells):
    """A strip with so many cells across, clamped at its root, its end turned once as time passes.

    Under an end moment alone the axis is an arc of the constant curvature angle/L, so that the end
    moves as (sin(a)/a, (1 - cos(a))/a) L. The angle is smooth in time, by a quintic.
    """
    h = HEIGHT / cells
    times = np.linspace(0.0, BENDS, 161)
    s = times / BENDS
    a = 2.0 * np.pi * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    rate = 2.0 * np.pi * 30.0 * s**2 * (1.0 - s) ** 2 / BENDS
    b = np.maximum(a, 1e-6)
    # Derivatives of the end's place by the angle; series where that is small.
    along = np.where(a < 1e-2, -a / 3.0, (b * np.cos(b) - np.sin(b)) / b**2)
    across = np.where(a < 1e-2, 0.5 - a**2 / 8.0, (b * np.sin(b) - (1.0 - np.cos(b))) / b**2)

    def table(values):
        return {"table": np.stack([times, values], axis=1).tolist()}

    end = ROOT + LENGTH
    clamp = {"body": "strip", "region": {"box": {"min": [0.0, 0.0], "max": [ROOT, 2.0]}}}
    grip = {"body": "strip", "region": {"box": {"min": [end, 0.0], "max": [end + 1.0, 2.0]}}}
    strip = box([0.0, 0.5], [end + 1.0, 0.5 + HEIGHT]) | {"formulation": "total-lagrangian"}
    case = scene(
        2, {"strip": strip}, cell=h, cells=[round((end + 1.0) / h), round(1.5 / h)],
        end=BENDS + RESTS, step=0.02 * h, damping={"mass": 1.5},
        constraints={
            "clamp": clamp | {"velocity": [0.0, 0.0]},
            "end": grip | {
                "velocity": [table(LENGTH * along * rate), table(LENGTH * across * rate)],
                "rotation": {"about": [end, LINE], "rate": table(rate)},
            },
        },
    )  # fmt: skip
    case["materials"]["soft"] |= {"young": E, "poisson": 0.0}
    return case


def block():
    """Moment, and radii across the height, of a bent block of the same material, exactly.

    Lengths are k r along it, with the curvature k = 2 pi/L, and r' across, from the inner side at
    the end of y. Of nu = 0 the energy is mu/2 (r'^2 + k^2 r^2 - 2) - mu ln(k r r'), so that
    q = r' - 1/r' has the slope k^2 r - 1/r, and is zero at both sides; M = dU/dk.
    """
    k, n = 2.0 * np.pi / LENGTH, 200
    h = HEIGHT / n

    def slopes(r, q):
        return np.array([0.5 * (q + np.sqrt(q * q + 4.0)), k * k * r - 1.0 / r])

    def across(inner):
        found = [np.array([inner, 0.0])]
        for _ in range(n):
            y = found[-1]
            a = slopes(*y)
            b = slopes(*(y + 0.5 * h * a))
            c = slopes(*(y + 0.5 * h * b))
            d = slopes(*(y + h * c))
            found.append(y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d))
        return np.array(found)

    low, high = 1.0 / k - HEIGHT, 1.0 / k
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if across(middle)[-1, 1] > 0.0 else (middle, high)
    r = across(middle)[:, 0]
    return np.trapezoid(0.5 * E * (k * r**2 - 1.0 / k), dx=h), r


def solved(cells):
    """Moment at the end, greatest distance from the exact places over L, and seconds."""
    sim = start(bent(cells))
    x, began = field(sim, "x"), perf_counter()
    while not sim.finished:
        sim.advance()
        if abs(sim.time - (BENDS + RESTS - 1.0)) < 0.5 * sim.dt:
            sim.diagnostics()
    line, seconds = sim.diagnostics(), perf_counter() - began  # a mean over the last unit
    k, (_, radii) = 2.0 * np.pi / LENGTH, block()
    bends = (x[:, 0] > ROOT) & (x[:, 0] < ROOT + LENGTH)
    angle, depth = k * (x[bends, 0] - ROOT), LINE + 0.5 * HEIGHT - x[bends, 1]
    r = np.interp(depth, np.linspace(0.0, HEIGHT, len(radii)), radii)
    exact = np.stack([ROOT + r * np.sin(angle), LINE + 1.0 / k - r * np.cos(angle)], axis=1)
    off = np.abs(field(sim, "x")[bends] - exact).max() / LENGTH
    return line["torque.end-z"], off, seconds


@pytest.mark.wide
def test_the_end_moment_and_the_circle():
    """Above the exact moment by 4.8 and 1.4 % with 2 and 4 cells across; E I angle/L within 3 %.

    The exact one is 2.5 % below that of a thin strip. Places are right to 0.2 % of L, as both ends
    are held across too.
    """
    thin, exact = E * HEIGHT**3 / 12.0 * 2.0 * np.pi / LENGTH, block()[0]
    assert exact / thin == pytest.approx(0.97486, abs=1e-4)
    coarse, fine = solved(2), solved(4)
    for (moment, off, _), near in ((coarse, 0.055), (fine, 0.016)):
        assert 0.0 < moment / exact - 1.0 < near
        assert abs(moment / thin - 1.0) < 0.03
        assert off < 2.2e-3
    assert fine[0] - exact < 0.35 * (coarse[0] - exact)  # second order


if __name__ == "__main__":
    for n in (2, 4):
        moment, off, seconds = solved(n)
        print(n, moment / block()[0] - 1.0, off, seconds)
