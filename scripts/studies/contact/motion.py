"""How bodies that meet move: against exact solutions, on cells of one size and of half of it."""

from math import cos, radians, sin

import numpy as np
from ruamel.yaml import YAML
from studies import scenes
from studies.harness import CASES
from studies.scenes import a_line, ball, box, by_turns, looked, reading

import pgimp

SOLID = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
#: Along each direction of the blocks whose steps are timed, by dimension.
CELLS = {2: 120, 3: 20}


def case_of(bodies, size, cell, end, solid=SOLID, **parts):
    """A case of soft bodies, whose regions and velocities are given by name."""
    entries = {
        name: {"material": "solid", "region": region, "velocity": velocity}
        for name, (region, velocity) in bodies.items()
    }
    return scenes.case_of(size, cell, {"solid": solid}, entries, end, **parts)


def slope_of(angle):
    return sin(radians(angle)), cos(radians(angle))


def run(case, overrides=()):
    """First and last line of the history."""
    simulation = pgimp.Simulation(case, overrides=overrides)
    first = simulation.diagnostics()
    simulation.advance()
    return first, simulation.diagnostics()


def energy(line):
    return line["kinetic-energy"] + line["strain-energy"]


def bars(cell):
    """Two bars meet head on: the rebound over the speed before, and the energy lost."""
    bodies = {
        "a": (box([2.0], [12.0]), [0.05]),
        "b": (box([12.0 + 0.5 * cell], [22.0 + 0.5 * cell]), [-0.05]),
    }
    solid = {"model": "linear-1d", "young": 100.0, "density": 1.0}
    first, last = run(case_of(bodies, [25.0], cell, 7.0, solid, contact=[{"bodies": "all"}]))
    return (
        -last["body.a.momentum-x"] / first["body.a.momentum-x"],
        1.0 - energy(last) / energy(first),
    )


def disks(cell):
    """Sulsky's disks: energy lost when they have parted."""
    current = {f"bodies.{name}.formulation": "updated-lagrangian" for name in ("left", "right")}
    current |= {"grid.cell": [cell, cell], "method.affine": False}
    first, last = run(CASES / "disks.yaml", current)
    return 1.0 - energy(last) / energy(first)


def edges(cell):
    """Blocks pressed together slide past each other without friction: change of their momentum."""
    bodies = {
        "a": (box([2.0, 2.0], [5.0, 5.0]), [0.5, 1.0]),
        "b": (box([5.0, 2.0], [8.0, 5.0]), [-0.5, -1.0]),
    }
    first, last = run(case_of(bodies, [14.0, 8.0], cell, 1.2, contact=[{"bodies": "all"}]))
    return abs(last["body.a.momentum-y"] / first["body.a.momentum-y"] - 1.0)


def tied(steps=1000, floor="slip"):
    """A block in two tied parts and in one: greatest difference of place and velocity."""
    step = 0.008
    time = {"end": steps * step, "step": step}
    parts = {"gravity": [0.0, -1.0], "boundaries": {"y-min": floor, "x-max": "slip"}}
    motion = {"rotation": {"about": [4.0, 2.5], "rate": 0.3}, "translation": [0.3, 0.1]}
    whole = {"a": (box([2.0, 1.0], [6.0, 4.0]), motion)}
    halves = {
        "a": (box([2.0, 1.0], [4.0, 4.0]), motion), "b": (box([4.0, 1.0], [6.0, 4.0]), motion)
    }  # fmt: skip
    law = [{"bodies": "all", "law": "tie"}]
    found = []
    for bodies, contact in ((whole, []), (halves, law)):
        case = case_of(bodies, [12.0, 8.0], 1.0, 1.0, contact=contact, time=time, **parts)
        simulation = pgimp.Simulation(case)
        before = simulation.particles["position"]
        order = np.lexsort(np.round(before, 6).T)
        simulation.advance()
        particles = simulation.particles
        found.append(np.hstack([particles["position"], particles["velocity"]])[order])
    return np.abs(found[0] - found[1]).max()


def parting():
    """Part of the momentum that a resting block takes from one that touches it and moves away."""
    bodies = {
        "a": (box([2.0, 2.0], [5.0, 5.0]), [0.0, 0.0]),
        "b": (box([5.0, 2.0], [8.0, 5.0]), [1.0, 0.2]),
    }
    _, last = run(case_of(bodies, [14.0, 8.0], 1.0, 0.5, contact=[{"bodies": "all"}]))
    return abs(last["body.a.momentum-x"]) / last["momentum-x"]


def leaving(configuration, cell):
    """Greatest momentum that a ball at rest takes from a plate that leaves, over the plate's.

    In 2D and 3D, without friction and with it, straight and a little aside, in all steps.
    """
    most = 0.0
    for D in (2, 3):
        away = [0.3, *[0.0] * (D - 2), -1.0]
        bodies = {
            "ball": (ball([1.43] * (D - 1) + [1.67], 1.0), [0.0] * D),
            "plate": (box([0.23] * (D - 1) + [0.37], [2.63] * (D - 1) + [0.67]), away),
        }
        for friction in (0.0, 0.5):
            contact = [{"bodies": "all", "friction": friction}]
            case = case_of(bodies, [3.0] * D, cell, 0.2, contact=contact)
            for body in case["bodies"].values():
                body["formulation"] = configuration
            simulation = pgimp.Simulation(case)
            while not simulation.finished:
                simulation.step()
                line = simulation.diagnostics()
                taken = max(abs(line[f"body.ball.momentum-{axis}"]) for axis in "xyz"[:D])
                most = max(most, taken / abs(line[f"body.plate.momentum-{'xyz'[D - 1]}"]))
    return most


def incline(cell, angle=24.0, friction=0.3, law="friction"):
    """A block slides down a held slab: acceleration, heat over Coulomb's, cells by which it sinks.

    The velocity is fitted by a line, as the block vibrates: at the beginning the weight sets in at
    once.
    """
    g, slope = 10.0, slope_of(angle)
    gravity = [g * slope[0], -g * slope[1]]
    entry = {"law": law} | ({"friction": friction} if law == "friction" else {})
    simulation = pgimp.Simulation(_on_a_slab(9.0, cell, gravity, entry))
    first = simulation.diagnostics()
    lines, _, _ = looked(simulation, np.arange(0.6, 2.2001, 0.01), a_line)
    begin, end = lines[0], lines[-1]
    rows = np.array([(line["time"], line["body.block.momentum-x"] / 5.0) for line in lines])
    exact = g * (slope[0] - friction * slope[1])
    way = [line["body.block.centre-x"] for line in (first, begin, end)]
    sunk = (end["body.block.centre-y"] - first["body.block.centre-y"]) / cell
    heat = end["contact.slab+block.friction-heat"] - begin["contact.slab+block.friction-heat"]
    # While the block bounces it is not its weight that presses.
    name = "contact.slab+block.normal-impulse"
    press = (end[name] - begin[name]) / (end["time"] - begin["time"])
    acceleration = np.polyfit(*rows.T, 1)[0]
    return acceleration / exact, heat / (friction * press * (way[2] - way[1])), sunk


def sticking(cell, angle=24.0, friction=0.7):
    """A block that should stick on a slab: greatest way, in cells, by which it is off a tied one.

    What both do, bending and shear of slab and block, is no slip.
    """
    g, slope = 10.0, slope_of(angle)
    ramp = {"table": [[0.0, [0.0, 0.0]], [0.5, [g * slope[0], -g * slope[1]]]]}
    cases = [
        _on_a_slab(3.0, cell, ramp, entry) for entry in ({"friction": friction}, {"law": "tie"})
    ]
    return apart(cases, np.arange(0.1, 2.2001, 0.1)) / cell


def _on_a_slab(length, cell, gravity, law):
    """A block on a held slab, with a law of contact."""
    bodies = {
        "slab": (box([0.0, 0.0], [length, 0.5]), [0.0, 0.0]),
        "block": (box([0.5, 0.5], [1.5, 1.0]), [0.0, 0.0]),
    }
    return case_of(
        bodies, [length, 1.6], cell, 2.2, SOLID | {"young": 1e4, "density": 10.0}, gravity=gravity,
        boundaries={"y-min": "fixed", "x-min": "slip", "x-max": "slip"},
        contact=[{"bodies": ["slab", "block"], **law}],
    )  # fmt: skip


def apart(cases, times):
    """Greatest difference between where the block is along x in two cases."""
    one, other = (looked(case, times, reading("body.block.centre-x"))[0] for case in cases)
    return np.abs(np.array(one) - np.array(other)).max()


def cost(apart, dimensions, rounds=5):
    """Time of a step with contact over that without, by turns; bodies touch unless `apart`.

    Blocks of `CELLS` along each direction: in touch in about 5 layers.
    """
    cells = CELLS[dimensions]
    high = [cells + 2.0] * dimensions
    low = [2.0] * dimensions
    gap = 20.0 if apart else 0.0
    shift = [high[0] - 2.0 + gap, *[0.0] * (dimensions - 1)]
    second = [[a + b for a, b in zip(end, shift, strict=True)] for end in (low, high)]
    bodies = {"a": (box(low, high), [0.0] * dimensions), "b": (box(*second), [0.0] * dimensions)}
    size = [2.0 * high[0] + gap + 4.0, *[high[0] + 4.0] * (dimensions - 1)]
    simulations = [
        pgimp.Simulation(case_of(bodies, size, 1.0, 1e9, contact=contact))
        for contact in ([], [{"bodies": "all", "friction": 0.3}])
    ]
    return ratio(simulations, rounds, 8)


def ratio(simulations, rounds, steps):
    """CPU time of steps of the second of two simulations over that of the first: the least of each.

    Other work on the machine makes some longer, and none shorter.
    """
    for simulation in simulations:
        simulation.step(3)
    first, second = by_turns(simulations, rounds, steps).min(axis=0)
    return second / first


def heap(count=48, steps=800, radius=4.0, columns=(8,), gravity=1.0):
    """Disks or balls that fall into a box: time of a step over that without contact, most fields.

    They begin in as many columns along each direction but the last.
    """
    D, pitch = len(columns) + 1, 2.0 * radius + 1.0
    layer = int(np.prod(columns))
    places = [[*np.unravel_index(k % layer, columns), k // layer] for k in range(count)]
    bodies = {
        f"grain{k}": (
            ball([6.0 + pitch * x for x in place], radius), [0.5 * sin(7.0 * k), *[0.0] * (D - 1)],
        ) for k, place in enumerate(places)
    }  # fmt: skip
    size = [pitch * n + 6.0 for n in (*columns, -(-count // layer))]
    simulations = []
    for contact in ([{"bodies": "all", "friction": 0.3}], []):
        case = case_of(
            bodies, size, 1.0, 1e3, SOLID | {"young": 1e3}, gravity=[0.0] * (D - 1) + [-gravity],
            boundaries={
                f"{axis}-{end}": "unilateral"
                for axis in "xyz"[:D] for end in ("min", "max")[: 1 + (axis != "xyz"[D - 1])]
            },
            contact=contact,
        )  # fmt: skip
        simulations.append(pgimp.Simulation(case))
        simulations[-1].step(3)
    times, fields = np.zeros(2), 0
    for _ in range(steps // 20):
        times += by_turns(simulations, 1, 20)[0]
        fields = max(fields, 1 + max(simulations[0].core.rank.contact.fields))
    return times[0] / times[1], fields


def drum(rounds=9, steps=20):
    """Time of a step of cases/drum.yaml over that of its grains as one body at rest, and fields."""
    case = YAML(typ="safe").load(CASES / "drum.yaml")
    grains = [body["region"] for body in case["bodies"].values() if "rigid" not in body]
    whole = {"material": "gel", "surface": "whole-particles", "region": {"union": grains}}
    alone = {"bodies": {"grains": whole}, "contact": [], "gravity": [0.0, 0.0]}
    simulations = [pgimp.Simulation(pgimp.load(each)) for each in (case, case | alone)]
    for simulation in simulations:
        simulation.step(200)  # the heap settles
    found = by_turns(simulations, rounds, steps)
    fields = 1 + max(simulations[0].core.rank.contact.fields)
    return float(np.median(found[:, 0] / found[:, 1])), fields
