"""A block that one end turns for many turns: what stays of radii, energies, angular momentum."""

from math import pi
from time import perf_counter

import numpy as np
from studies.scenes import box, by_id, case_of, core

YOUNG, RATE, CENTRE = 100.0, 0.1, (4.0, 4.0)
#: How long the rate grows, and turns after which the block is looked at.
RISE, TURNS = 60.0, (3, 10, 50)


def watched(configuration):
    """Rows after some turns: changes of radii, spin and energy, the work a turn, steps and time.

    A block of 4 x 2 cells turns about its centre, by a grip on three eighths of it. Spin, energy
    and work are counted from the end of the first turn.
    """
    end = 0.5 * RISE + 2.0 * pi * TURNS[-1] / RATE
    solid = {"model": "neo-hookean", "young": YOUNG, "poisson": 0.3, "density": 1.0}
    case = case_of(
        [8.0, 8.0], 1.0, {"m": solid},
        {"b": {"material": "m", "region": box([2.0, 3.0], [6.0, 5.0]),
               "formulation": configuration}},
        end,
        constraints={"chuck": {
            "body": "b", "region": box([2.0, 3.0], [3.5, 5.0]),
            "rotation": {"about": [*CENTRE], "rate": {"ramp": {"to": RATE, "duration": RISE}}},
        }},
    )  # fmt: skip
    sim = core(case)
    X, held = _arms(sim), _held(sim)
    R = np.hypot(*X.T)
    began, rows, at = perf_counter(), [], [1, *TURNS]
    while not sim.finished:
        sim.advance()
        if (sim.time - 0.5 * RISE) * RATE < 2.0 * pi * at[0] and not sim.finished:
            continue
        line, turns, off = sim.diagnostics(), at.pop(0), np.hypot(*_arms(sim).T) / R - 1.0
        about = CENTRE[0] * line["momentum-y"] - CENTRE[1] * line["momentum-x"]
        now = np.array(
            [
                line["angular-momentum-z"] - about,
                line["kinetic-energy"] + line["strain-energy"],
                line["external-work"],
            ]
        )
        if turns == 1:
            first = now
            continue
        change = (now - first) / (first[0], first[1], first[1] * (turns - 1))
        rows.append((
            f"`{configuration}`, {turns} turns",
            f"{np.abs(off[held]).max():.0e}",
            f"{100.0 * np.abs(off[~held]).max():.2f} %",
            *(f"{100.0 * each:+.2f} %" for each in change),
            sim.step, f"{perf_counter() - began:.0f} s",
        ))  # fmt: skip
    return rows


def _arms(sim):
    """Positions from the axis, by number."""
    return by_id(sim, sim.particles.x[sim.live()]) - CENTRE


def _held(sim):
    """Whether particles are held, by number."""
    return by_id(sim, sim.particles.constraint[sim.live()])[:, 0] > 0
