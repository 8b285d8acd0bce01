"""Measures metals against exact results and writes their tables; see scripts/materials."""

import numpy as np
from studies.harness import options_of, origin, out, put, table
from studies.material import metals
from studies.scenes import by_turns, case_of, filled

import pgimp

ROUNDS, STEPS = 9, 6


def speed(rate):
    return f"{rate / 1e6:.2f} million"


def rows_of_waves(quick):
    """Rows 12, 14, 16 and 15 on two cell sizes."""
    cells = (100, 200) if quick else (400, 800)
    found = [metals.elastic_plastic(n) for n in cells]
    names = (
        ("elastic-plastic plates: precursor [m/s]", 5856.36, 1.0),
        ("the same: plastic wave [m/s]", 4607.76, 1.0),
        ("the same: stress behind the precursor [MPa]", 700.0, 1e-6),
        ("the same: stress behind the plastic wave [MPa]", 1053.5, 1e-6),
    )
    for column, (name, exact, unit) in enumerate(names):
        yield row(name, exact, cells, [one[column] * unit for one in found], found[-1][4])
    found = [metals.hugoniot(n) for n in cells]
    for column, (name, exact, unit) in enumerate((
        ("copper at 500 m/s: pressure [GPa]", 9.6115, 1e-9),
        ("the same: density over that before", 1.06165, 1.0),
        ("the same: shock speed [m/s]", 4305.25, 1.0),
    )):  # fmt: skip
        yield row(name, exact, cells, [one[column] * unit for one in found], found[-1][3])
    cells = (5, 10) if quick else (10, 20)
    found = [metals.tube(n) for n in cells]
    name = "thick tube, all plastic: pressure over the exact one of its radii"
    yield row(name, 1.0, cells, [one[0] for one in found], found[-1][1])
    cells = (2, 4) if quick else (4, 8)
    found = [metals.taylor(n) for n in cells]
    for column, (name, low, high) in enumerate((
        ("Taylor's bar: length [mm]", 21.4, 21.7), ("the same: radius at the wall [mm]", 6.9, 7.2),
        ("the same: greatest plastic strain", 2.97, 3.25),
    )):  # fmt: skip
        values = [one[column] for one in found]
        yield [
            name, f"{low:g} to {high:g}",
            *(f"{value:.2f} ({n} cells)" for value, n in zip(values, cells, strict=True)),
            "", speed(found[-1][3]),
        ]  # fmt: skip


def row(name, exact, cells, values, rate):
    """A row of a measured quantity with its error on the smaller cells."""
    shown = [f"{each:.5g} ({n} cells)" for each, n in zip(values, cells, strict=True)]
    return [name, f"{exact:g}", *shown, f"{100 * (values[-1] / exact - 1):+.2f} %", speed(rate)]


def rows_of_paths():
    """Rows 11 and 13, without a grid."""
    yield ["von-mises in uniaxial strain and pure shear, 1 and 100 steps: error", "0",
           f"{metals.paths():.0e}"]  # fmt: skip
    for steps in (200, 400, 4000):
        yield [f"johnson-cook: adiabatic heating at a strain of 1, {steps:,} steps [K]", "92.002",
               f"{metals.heating(steps):.3f}"]  # fmt: skip


def costs():
    """Particle-steps/s of a turning block that flows, each beside the neo-Hookean, by turns."""
    soft = {"young": 100.0, "poisson": 0.3, "density": 1.0}
    limit = {"model": "von-mises", "yield-stress": 0.5, "hardening": 1.0}
    cook = {
        "model": "johnson-cook", "a": 0.5, "b": 1.0, "n": 0.3, "c": 0.02, "m": 1.1,
        "reference-rate": 0.01, "specific-heat": 1.0, "temperature": 1.0, "melting": 3.0,
    }  # fmt: skip
    eos = {"eos": {"mie-gruneisen": {"c0": 9.0, "s": 1.5, "gamma": 2.0}}}
    materials = {
        "neo-hookean": {"model": "neo-hookean"}, "hooke": {"model": "hooke"}, "von-mises": limit,
        "von-mises with saturation": limit | {"saturation": {"stress": 0.5, "rate": 10.0}},
        "von-mises with kinematic hardening": limit | {"kinematic": 1.0},
        "johnson-cook": cook,
        "johnson-cook with damage and mie-gruneisen": cook | eos | {"damage": {"d1": 5.0}},
    }  # fmt: skip
    sims = [pgimp.Simulation(block(soft | entry)) for entry in materials.values()]
    count = len(sims[0].particles["id"])
    for sim in sims:
        sim.step(3)
    times = np.median(by_turns(sims, ROUNDS, STEPS), axis=0)
    for name, time in zip(materials, times, strict=True):
        yield [name, speed(count / time), f"{times[0] / time:.2f}"]


def block(material):
    """A block of 64,000 particles that turns and is strained beyond yield."""
    motion = {"rotation": {"about": [0.6] * 3, "rate": [0.0, 0.0, 0.4]}}
    body = {"material": "m", "velocity": motion} | filled([0.1] * 3, [1.1] * 3)
    return case_of([1.2] * 3, 0.05, {"m": material}, {"b": body}, 1.0, time={"step": 1e-4})


def main():
    """Measure, and write the tables; the page too unless it is quick."""
    quick = options_of("materials", quick="coarser, and no page").quick
    tables = {
        "metal-waves": table(
            ["test", "exact or published", "measured", "on half the cells", "error there",
             "particle-steps/s there"], rows_of_waves(quick),
        ),
        "metal-paths": table(["path", "exact", "measured"], rows_of_paths()),
        "metal-costs": table(
            ["material", "particle-steps/s", "over those of neo-hookean"], costs(),
            f"Measured on one core of {origin()}.",
        ),
    }  # fmt: skip
    print("\n".join(tables.values()))
    put(tables, out("materials") / "metals.md", not quick)
