"""Where grips end, by the part of a vertex's mass that they need in the initial configuration.

Forces of a bar of 10 cells, moments of a block of 16 x 4 that is bent, and of a ring: errors say by
how much an edge acts beyond where it is, or before. Motion is slow, so that inertia is nothing.
"""

import numpy as np
from studies.scenes import ball, box, case_of, core

from pgimp.physics.loads import constraints
from pgimp.scene import loads

YOUNG, SPEED = 100.0, 0.05
LINE = {"model": "linear-1d", "young": YOUNG, "density": 1.0}
SOLID = {"model": "neo-hookean", "young": YOUNG, "poisson": 0.3, "density": 1.0}
#: Places of edges in their cells.
PLACES = (0.0, 0.25, 0.5, 0.75)


def _read(case, since, **columns):
    """Columns of the history each tenth step, and the time; from a time on."""
    sim, lines = core(case), []
    while not sim.finished:
        sim.advance()
        if sim.step % 10 == 0:
            line = sim.diagnostics()
            if sim.time > since:
                lines.append([sim.time, *(read(line) for read in columns.values())])
    return np.array(lines).T


def _bar(left, right, end, since):
    """Mean error of the force of a bar, and how much it jumps; four particles a cell."""
    errors, jumps = [], []
    for place in PLACES:
        a = 2.0 + place
        grips = {
            name: {"body": "b", "region": box([low], [low + 2.0]), "velocity": [{"table": rate}]}
            for name, low, rate in (("left", a, left), ("right", a + 12.0, right))
        }
        bodies = {"b": {"material": "m", "region": box([a], [a + 14.0])}}
        case = case_of([26.0], 1.0, {"m": LINE}, bodies, end, courant=0.2, per_cell=4,
                       constraints=grips)  # fmt: skip
        _, force, way = _read(
            case, since,
            force=lambda line: 0.5 * (line["constraint.right-x"] - line["constraint.left-x"]),
            way=lambda line: line["displacement.right-x"] - line["displacement.left-x"],
        )  # fmt: skip
        error = force / (YOUNG * np.log1p(way / 10.0)) - 1.0
        errors.append(error.mean())
        jumps.append(np.diff(error).std())
    return np.mean(errors), np.mean(jumps)


def pulled():
    """A bar is pulled away from one grip, by two cells."""
    return _bar([[0.0, 0.0]], [[0.0, 0.0], [4.0, SPEED]], 42.0, 10.0)


def carried():
    """A bar is stretched by a hundredth while both grips carry it through four cells."""
    v, w = 2.0 * SPEED, 0.1 / 36.0
    right = [[0.0, 0.0], [4.0, v + w], [36.0, v + w], [40.0, v]]
    return _bar([[0.0, 0.0], [4.0, v]], right, 60.0, 20.0)


def bent(angle, configuration="current", rise=60.0):
    """Error of the moment of a block between grips that turn by an angle to each other."""
    errors = []
    for place in PLACES:
        times = np.linspace(0.0, rise, 121)
        s = times / rise
        turned = 0.5 * angle * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        way = 8.0 * (1.0 - np.sinc(turned / np.pi))  # of the axes, with ends of an arc of 16
        rate, speed = np.gradient(turned, times), np.gradient(way, times)
        a, grips = 4.0 + place, {}
        for name, x, side in (("left", 0.0, 1.0), ("right", 16.0, -1.0)):
            first = a + x - 2.0 * (side > 0.0)
            grips[name] = {
                "body": "b", "region": box([first, 6.0], [first + 2.0, 10.0]),
                "velocity": [{"table": np.transpose([times, side * speed]).tolist()}, 0.0],
                "rotation": {
                    "about": [a + x, 8.0],
                    "rate": {"table": np.transpose([times, -side * rate]).tolist()},
                },
            }  # fmt: skip
        region = box([a - 2.0, 6.0], [a + 18.0, 10.0])
        body = {"material": "m", "region": region, "formulation": configuration}
        case = case_of([26.0, 16.0], 1.0, {"m": SOLID}, {"b": body}, rise + 12.0,
                        constraints=grips, damping={"mass": 0.3})  # fmt: skip
        _, moment, turn = _read(
            case, 0.5 * rise,
            moment=lambda line: 0.5 * (line["torque.right-z"] - line["torque.left-z"]),
            turn=lambda line: line["angle.right"] - line["angle.left"],
        )  # fmt: skip
        exact = YOUNG / (1.0 - 0.3**2) * 4.0**3 / 12.0 / 16.0 * turn
        errors.append((moment / exact).mean() - 1.0)
    return np.mean(errors)


def ringed(configuration="current"):
    """Error of the moment of a disk held within 3 cells, turned beyond 7 of them."""
    errors, angle = [], 2e-3
    for place in PLACES:
        c = [10.0 + place, 10.0]
        rate = {"table": [[0.0, 0.0], [8.0, angle / 8.0], [16.0, 0.0]]}
        grips = {
            "inner": {"body": "b", "region": ball(c, 3.0), "rotation": {"about": c, "rate": 0.0}},
            "outer": {"body": "b", "rotation": {"about": c, "rate": rate},
                      "region": {"difference": [ball(c, 9.0), ball(c, 7.0)]}},
        }  # fmt: skip
        body = {"material": "m", "region": ball(c, 8.5), "formulation": configuration}
        case = case_of([21.0, 20.0], 1.0, {"m": SOLID}, {"b": body}, 24.0, constraints=grips,
                       damping={"mass": 0.5})  # fmt: skip
        _, moment = _read(case, 20.0, moment=lambda line: line["torque.outer-z"])
        exact = 4.0 * np.pi * YOUNG / 2.6 * angle / (3.0**-2 - 7.0**-2)
        errors.append(moment.mean() / exact - 1.0)
    return np.mean(errors)


def rows():
    """A row for the current configuration, and for each least part in the initial one."""
    found, own = [], constraints.LEAST_PART
    for configuration, part in (("current", 0.0), ("initial", 0.0), ("initial", own)):
        loads.LEAST_PART = part
        bars = (*pulled(), carried()[0]) if configuration == "current" else ()
        bends = [bent(angle, configuration) for angle in (0.01, 1.0)]
        errors = *bars[::2], *bends, ringed(configuration)
        words = [f"{100.0 * e:+.1f} %" for e in errors]
        name = f"`{configuration}`, " + (f"{part:g}" if part else "all they reach")
        mark = "**" * (configuration == "current" or part > 0.0)
        jumps = f"{100.0 * bars[1]:.1f} %" if bars else ""
        found.append([mark + name + mark, *[""] * (5 - len(words)), *words, jumps])
    loads.LEAST_PART = own
    return found
