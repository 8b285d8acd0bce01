"""Impact, plastic flow, liquids and long runs, with an order of phases."""

from time import process_time

from studies.flow.liquids import slosh, still
from studies.phases.bodies import vibration, watched
from studies.scenes import case_of, core, filled

import pgimp


def impact(method):
    """Two bars of 20 cells that meet at a tenth of the wave speed: restitution, energy lost."""
    bar = {"material": "m"}
    sim = core(case_of(
        [64.0], 1.0, {"m": {"model": "linear-1d", "young": 1.0, "density": 1.0}},
        {"a": bar | filled([4.3], [24.3]) | {"velocity": [0.1]}, "b": bar | filled([26.6], [46.6])},
        100.0, method=method, contact=[{"bodies": "all"}],
    ))  # fmt: skip
    first = vibration(sim)
    watched(sim, lambda sim: 0.0)
    line = sim.diagnostics()
    apart = line["body.b.momentum-x"] - line["body.a.momentum-x"]
    lost = line["dissipated-energy"] / (first + 0.1 * 0.1 * 20.0 / 4.0)
    return apart / (0.1 * 20.0), lost


def of_case(name, columns, method, **changes):
    """Columns of the last line of a case's history, and CPU seconds."""
    changes = {f"method.{key}": value for key, value in method.items()} | changes
    sim = pgimp.Simulation(f"cases/{name}.yaml", overrides=changes)
    sim.step()
    began = process_time()
    sim.advance()
    line = sim.diagnostics() or {}
    return [line[each] for each in columns], process_time() - began


def taylor(method):
    """Taylor's bar: its length at the end, energy that the method lost, over that at the start."""
    names = ("body.bar.centre-y", "dissipated-energy", "plastic-work", "kinetic-energy",
             "strain-energy", "external-work")  # fmt: skip
    (centre, gone, plastic, kinetic, strain, work), seconds = of_case(
        "taylor-axisymmetric", names, method
    )
    return centre, (gone - plastic) / (gone + kinetic + strain - work), seconds


def dam(method):
    """The dam break until it reaches the far wall: energy lost over the work of gravity."""
    (gone, work), seconds = of_case(
        "dam-break", ("dissipated-energy", "external-work"), method, **{"time.end": 0.6}
    )
    return gone / work, seconds


def turned_block(method):
    """The exact block that turns and breathes: errors of displacement and stress, half way."""
    names = ("error.displacement-l2", "error.stress-l2")
    (way, stress), _ = of_case("spinning-block", names, method, **{"time.end": 0.5})
    return way, stress / (0.4 * 2.0e5)


def waters(method):
    """Water: error of the level at rest and noise of its pressure; frequency of sloshing."""
    level, noise, _, _ = still(method, 2)
    _, _, frequency, _ = slosh(method, 2)
    return level, noise, frequency
