"""One run of a case in this process, watched for whether it finishes and for its energy."""

import json
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from studies import harness
from studies.scenes import core

from pgimp.errors import RunError

CASES = harness.CASES / "hard"
#: A run is stable if it finishes and its energy never grows by more than this part of the most.
BOUND = 0.05
#: A run whose energy has grown by so much is stopped.
HOPELESS = 10.0
LINES = 400


class Watched(NamedTuple):
    """A run that has ended: its simulation, the lines of its history, and how it ended."""

    sim: Any
    lines: dict[str, np.ndarray]
    growth: float
    fault: str
    seconds: float

    @property
    def stable(self) -> bool:
        """Whether it finished with its energy bounded."""
        return not self.fault and self.growth <= BOUND


def words(changes):
    """Changes of a case by key path as the command line would have them."""
    return [f"{key}={json.dumps(value)}" for key, value in changes.items()]


def begin(name, changes):
    """The simulation of cases/hard/NAME.yaml with some changes, on one rank."""
    return core(CASES / f"{name}.yaml", words(changes))


def watch(sim, lines=LINES, each=None):
    """Run a simulation from its start to its end, or until it fails; see `Watched`.

    The growth of the energy is the greatest excess, in any line, of kinetic and strain energy over
    what there was at first and what the loads have done, over the greatest energy of any line. The
    history has some lines, evenly in time; at each of them `each` is called with the simulation.
    """
    began = perf_counter()
    found = [sim.diagnostics()]
    excess, most, fault = 0.0, 0.0, ""
    number = 1
    try:
        while not sim.finished:
            sim.advance()
            if not sim.finished and sim.time < number * sim.clock.end / lines:
                continue
            number += 1
            line = sim.diagnostics()
            found.append(line)
            if each:
                each(sim)
            energy = line["kinetic-energy"] + line["strain-energy"]
            excess = max(excess, -line["dissipated-energy"])
            known = energy - max(-line["dissipated-energy"], 0.0)
            most = max(most, found[0]["kinetic-energy"] + found[0]["strain-energy"], known)
            if not excess <= HOPELESS * most:
                fault = f"its energy has grown {HOPELESS:g}-fold"
                break
    except RunError as error:
        fault = reason(str(error))
    growth = excess / most if most > 0.0 else 0.0
    columns = {key: np.array([line[key] for line in found]) for key in found[0]}
    return Watched(sim, columns, growth, fault, perf_counter() - began)


def reason(message):
    """The short form of why a run stopped."""
    for text, short in (
        ("inside out", "inverted"), ("not a finite", "not finite"),
        ("more than a cell", "too fast"), ("left the domain", "left the domain"),
        ("blown up", "blown up"),
    ):  # fmt: skip
        if text in message:
            return short
    return message.splitlines()[0]


def field(sim, name):
    """A field of all particles in ascending id, a copy."""
    p, rows = sim.particles, sim.live()
    return getattr(p, name)[rows[np.argsort(p.id[rows])]]
