"""Measures factors of safety against bounds and exact results; see scripts/strength."""

from math import asin, cos, radians, sin, tan
from time import process_time

from studies.harness import origin

import pgimp
from pgimp.errors import NoRestError
from pgimp.utilities.study.bisect_entry import Bisection
from pgimp.utilities.study.bisection import Bracket, bisect
from pgimp.utilities.study.plan import Bisected
from pgimp.utilities.study.runs import DONE, Outcome
from pgimp.utilities.study.sliding import greatest, limit

#: Height of all slopes, weight of the soil, its stiffness, over which strength is about 1e-4.
HEIGHT, WEIGHT, YOUNG = 1.0, 10.0, 1.0e5
#: Width of the last bracket.
CLOSE = 0.01
#: Part of the unbalanced force at rest, and most steps for each cell of the height.
TOLERANCE, STEPS = 1.0e-4, 500


def case(cell, size, region, soil, **parts):
    """A slope at rest, whose soil a stage weakens."""
    material = {"model": "mohr-coulomb", "density": 1.0, "young": YOUNG, "poisson": 0.3} | soil
    rest = {"tolerance": TOLERANCE}
    weak = {"name": "weak", "strength-reduction": {"factor": 1.0}}
    weak["equilibrate"] = rest | {"steps": round(STEPS * HEIGHT / cell)}
    return {
        "format": 1, "dimensions": 2,
        "grid": {"size": size, "cell": [cell, cell]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2], "volumetric": "b-bar"},
        "time": {"end": 2.0e-3, "step": {"courant": 0.4}, "stages": [weak]},
        "start": {"equilibrate": rest},
        "materials": {"soil": material},
        "bodies": {"soil": {"material": "soil", "region": region}},
        "gravity": [0.0, -WEIGHT],
        "boundaries": {"x-min": "slip", "y-min": "fixed"},
    } | parts  # fmt: skip


def cut(cell):
    """A vertical cut of clay, gamma H/c = 3, twice as deep as high."""
    box = {"box": {"min": [0.0, 0.0], "max": [4.0, 2.0]}}
    out = {"box": {"min": [2.0, 1.0], "max": [4.0, 2.0]}}
    soil = {"cohesion": WEIGHT * HEIGHT / 3.0, "friction-angle": 0.0}
    walls = {"x-min": "slip", "x-max": "slip", "y-min": "fixed"}
    size = [4.0, 2.0 + 2.0 * cell]
    return case(cell, size, {"difference": [box, out]}, soil, boundaries=walls)


def slope(cell):
    """Griffiths and Lane's slope of 1 in 2 on rock: friction 20 degrees, c = 0.05 gamma H."""
    box = {"box": {"min": [0.0, 0.0], "max": [3.25, 1.0]}}
    out = {"half-space": {"point": [3.25, 0.0], "normal": [-1.0, -2.0]}}
    soil = {"cohesion": 0.05 * WEIGHT * HEIGHT, "friction-angle": 20.0}
    return case(cell, [3.75, 1.0 + 2.0 * cell], {"difference": [box, out]}, soil)


def endless(cell, dilation):
    """An infinite slope of 20 degrees by tilted gravity between periodic ends: friction 30."""
    a, wide = radians(20.0), 4.0 * cell
    soil = {"cohesion": 0.0, "friction-angle": 30.0, "dilation-angle": dilation}
    return case(
        cell, [wide, 1.0 + 2.0 * cell], {"box": {"min": [0.0, 0.0], "max": [wide, 1.0]}}, soil,
        gravity=[WEIGHT * sin(a), -WEIGHT * cos(a)],
        boundaries={"x-min": "periodic", "x-max": "periodic", "y-min": "fixed"},
    )  # fmt: skip


def sliding(dilation):
    """Factor of safety of the infinite slope.

    Along a plane of sliding no strain: tau/sigma is tan(phi) if flow is along the normal, sin(phi)
    without dilation.
    """
    ratio = tan(radians(20.0))
    return tan(radians(30.0)) / (ratio if dilation else tan(asin(ratio)))


#: Name, case of a cell, cells, first and last factor, least and greatest known result, and source.
PROBLEMS = (
    ("vertical cut of clay", cut, (1 / 8, 1 / 16), (1.0, 1.6), 3.77 / 3, 3.785 / 3,
     "bounds of Pastor"),
    ("slope of 1 in 2", slope, (1 / 8, 1 / 16), (1.0, 1.8), 1.38, 1.4,
     "Bishop; Griffiths and Lane"),
    ("infinite slope, flow along the normal", lambda h: endless(h, 30.0), (1 / 4, 1 / 8),
     (1.3, 1.8), sliding(30.0), sliding(30.0), "exact"),
    ("infinite slope, no dilation", lambda h: endless(h, 0.0), (1 / 4, 1 / 8), (1.3, 1.8),
     sliding(0.0), sliding(0.0), "exact"),
)  # fmt: skip


def find(made, cell, between):
    """The bracket of a problem, its particles and steps, and the seconds of its runs."""
    count = steps = 0
    seconds = 0.0
    entry = Bisection(
        key="time.stages.0.strength-reduction.factor", between=between, tolerance=CLOSE
    )

    def run(factor):
        nonlocal count, steps, seconds
        entries = made(cell)
        entries["time"]["stages"][0]["strength-reduction"]["factor"] = factor
        began, rests = process_time(), True
        sim = pgimp.Simulation(entries)
        sim.advance(entries["time"]["end"])
        start = {name: sim.particles[name] for name in ("id", "position")}
        try:
            sim.advance()
        except NoRestError:
            rests = False
        seconds += process_time() - began
        count, steps = len(sim.particles["id"]), steps + sim.steps
        moved, most = greatest(start, sim.particles, sim.case), limit(entry, sim.case)
        slid = most if rests and moved > most else None
        return Outcome(None, DONE, value=float(rests and slid is None), moved=moved, slid=slid)

    run(between[0])  # compiles
    steps, seconds = 0, 0.0
    bracket = Bracket(Bisected("", None, cell, None))
    for _ in bisect(bracket, entry, run):
        pass
    return bracket, count, steps, seconds


def rows():
    """Rows of the table."""
    for name, made, cells, between, least, most, source in PROBLEMS:
        for cell in cells:
            bracket, count, steps, seconds = find(made, cell, between)
            F = bracket.middle
            error = max(least - F, F - most, 0.0) / least
            known = f"{least:.4f}" if least == most else f"{least:.3f} to {most:.3f}"
            low, high = sorted((bracket.rests, bracket.moves))
            yield (
                f"| {name} | 1/{1 / cell:.0f} | {low:.3f} to {high:.3f} | {known} ({source}) | "
                f"{100.0 * error:.1f} % | {count:,} | {len(bracket.trials)} | {steps:,} | "
                f"{seconds:.1f} s |"
            )


def main():
    """Print the table."""
    heads = ("problem", "cell over height", "factor", "known", "error", "particles", "runs")
    print(f"| {' | '.join([*heads, 'steps', 'time'])} |")
    print("|---" * 9 + "|")
    for row in rows():
        print(row, flush=True)
    print(f"\nTime of all runs of a result, on one core of {origin()}.")
