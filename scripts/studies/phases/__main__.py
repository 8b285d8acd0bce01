"""Measures orders of phases against each other, with their cost; see scripts/phases."""

import numpy as np
from studies.hard.courant import limits, moving_limit
from studies.harness import options_of, origin, table
from studies.method.bodies import SHAPES
from studies.phases import bodies, scenes
from studies.phases.long import SCENES
from studies.scenes import by_turns, case_of, filled

import pgimp

METHODS = {
    "`last`": {},
    "`last`, affine": {"affine": True},
    "`last-mapped`": {"stress": "last-mapped"},
    "`average`": {"stress": "average"},
    "`average`, affine": {"stress": "average", "affine": True},
}
BOTH = {name: METHODS[name] for name in ("`last`", "`average`")}
FRAMES = {"at rest": {}, "turns twice": {"turn": 0.02}, "moves at 0.1 c": {"velocity": 0.1}}
ROUNDS, STEPS = 11, 20


def _n(value, digits=3):
    return "fails" if value is None else f"{value:.{digits}f}"


def waves():
    """Bars of ten cells over 100 periods, in frames that move at parts of the wave speed."""
    rows = []
    for name, method in METHODS.items():
        found = [bodies.wave(method, V) or (None, None) for V in (0.0, 0.05, 0.2, 1.0)]
        rows.append([name, *(f"{_n(energy)}, {_n(motion)}" for energy, motion in found)])
    for courant in (0.6, 0.9):
        method = {"stress": "average"}
        found = [bodies.wave(method, V, courant=courant) for V in (0.0, 0.05, 0.2, 1.0)]
        cells = [f"{_n(energy)}, {_n(motion)}" for energy, motion in found]
        rows.append([f"`average`, `courant: {courant}`", *cells])
    print(table(["energy, amplitude of the mode left", "V = 0", "0.05", "0.2", "1"], rows))


def blocks():
    """Blocks that bend, in 2D and 3D."""
    rows = [
        [name, *(_n((bodies.block(method, **frame) or [None])[0]) for frame in FRAMES.values()),
         _n((bodies.block(method, turn=0.02) or [0, None])[1]),
         _n((bodies.block(method, 3, end=320.0) or [None])[0])]
        for name, method in METHODS.items()
    ]  # fmt: skip
    print(table(["energy of a block left", *FRAMES, "spin left", "3D"], rows))


def shapes():
    """The same by shape."""
    rows = [
        [f"`{shape}`, {name}",
         *(_n((bodies.block({"shape": shape, **method}, **frame) or [None])[0])
           for frame in FRAMES.values())]
        for shape in (*SHAPES, "cpdi-corners")
        for name, method in BOTH.items()
    ]  # fmt: skip
    print(table(["energy of a block left", *FRAMES], rows))


def others():
    """Spin, impact, metal, liquids, and a scene with an exact solution."""
    rows = []
    for name, method in METHODS.items():
        energy, spin = bodies.dzhanibekov(method) or (None, None)
        back, lost = scenes.impact(method)
        centre, metal, seconds = scenes.taylor(method)
        water, wet = scenes.dam(method)
        level, noise, frequency = scenes.waters(method)
        way, stress = scenes.turned_block(method)
        rows.append([
            name, f"{_n(energy)}, {_n(spin)}", f"{_n(back)}, {lost:.2%}",
            f"{1e3 * centre:.3f} mm, {metal:.2%}, {seconds:.1f} s", f"{water:.2%}, {wet:.1f} s",
            f"{level:.2%}, {noise:.2%}, {frequency:.2%}", f"{1e3 * way:.1f} mm, {stress:.1%}",
        ])  # fmt: skip
        print(rows[-1], flush=True)
    print(table([
        "", "brick in 3D: energy, spin left", "bars: restitution, lost",
        "Taylor's bar: centre, lost, time", "dam break: lost, time",
        "water: level, noise, frequency", "exact block: displacement, stress",
    ], rows))  # fmt: skip


def long(scenes=()):
    """Small scenes after 100,000 steps; each row as it is known."""
    for scene in scenes or SCENES:
        row = [scene, *(_n(SCENES[scene](method), 4) for method in METHODS.values())]
        print(row, flush=True)


def steps():
    """Largest stable Courant numbers."""
    rows = [
        [name, *(_n(limits(method, D, n, 1500, 0.02)[0], 2) for D in (1, 2) for n in (1, 2, 4)),
         *(_n(moving_limit(method, 1, 2, V, 0.02, 2000), 2) for V in (0.1, 1.0))]
        for name, method in METHODS.items()
    ]  # fmt: skip
    per = [f"{D}D, {n} a cell" for D in (1, 2) for n in (1, 2, 4)]
    print(table(["largest stable Courant number", *per, "at 0.1 c", "at 1 c"], rows))


def costs():
    """Time of a step over that with `last`, by turns, of large blocks that drift."""
    rows = []
    for name, method in METHODS.items():
        found = []
        for D, n in ((2, 64.0), (3, 18.0)):
            body = filled([4.0] * D, [4.0 + n] * D) | {"material": "m", "velocity": [0.01] * D}
            plain, other = (
                pgimp.Simulation(case_of([n + 8.0] * D, 1.0, bodies.SOLID, {"b": body}, 1e6,
                                         method=each)) for each in ({}, method)
            )  # fmt: skip
            for sim in (plain, other):
                sim.step(STEPS)
            spent = by_turns((plain, other), ROUNDS, STEPS)
            found.append(f"{np.median(spent[:, 1] / spent[:, 0]):.2f}")
        rows.append([name, *found])
    print(table(["time of a step over `last`", "2D", "3D"], rows))


def main():
    """Print all tables, or some."""
    parts = {part.__name__: part for part in (waves, blocks, shapes, others, long, steps, costs)}
    words = {"nargs": "*", "among": parts, "help": "tables to measure"}
    options = options_of("phases", tables=words, scenes={"among": SCENES})
    print(f"Measured on one core of {origin()}.\n")
    for name in options.tables or parts:
        parts[name](*([options.scenes] if name == "long" else []))
        print(flush=True)
