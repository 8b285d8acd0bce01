"""What blocks that turn for long gain or lose of spin and of energy, with `affine`, by shape.

Run as ``scripts/hard turns``: free blocks of 6 and 12 cells, two particles a cell
and direction, their edges moving at a twentieth and at a fifth of the speed of shortening waves;
writes the table of docs/methods.md, scripts/pages/tables/turns.md.
"""

from math import pi, sqrt

import numpy as np
from studies.harness import Table, put
from studies.method.bodies import simulation
from studies.pareto.candidates import SHAPES
from studies.scenes import filled

from pgimp.errors import RunError

METHODS = [*((shape, "current") for shape in SHAPES if shape != "mpm"), ("gimp", "initial")]
#: Cells across, and speed of the edges over that of waves.
BLOCKS = ((6, 0.05), (6, 0.2), (12, 0.2))
TURNS = (5, 20, 50)
POISSON = 0.3
WAVE = sqrt((1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
#: A block has torn when a particle is so much farther from the middle than the corner was.
TORN = 1.5


def changes(shape, configuration, cells, speed):
    """Relative changes of spin and energy after each of `TURNS`; None from where it has torn."""
    rate = 2.0 * speed * WAVE / cells
    low, middle = 0.5 * cells, float(cells)
    body = filled([low, low], [low + cells, low + cells])
    body |= {
        "velocity": {"rotation": {"about": [middle, middle], "rate": rate}},
        "formulation": configuration,
    }
    end = TURNS[-1] * 2.0 * pi / rate
    sim = simulation((shape, True, 2), [2 * cells] * 2, body, end, poisson=POISSON)
    found = []

    def spin_and_energy():
        line = sim.diagnostics()
        return np.array(
            [line["angular-momentum-z"], line["kinetic-energy"] + line["strain-energy"]]
        )

    first = spin_and_energy()
    try:
        while not sim.finished:
            sim.advance()
            if sim.time >= TURNS[len(found)] / TURNS[-1] * end * (1.0 - 1e-12):
                if np.abs(sim.particles.x[sim.live()] - middle).max() > TORN * sqrt(0.5) * cells:
                    break
                found.append(spin_and_energy() / first - 1.0)
    except RunError:
        pass
    return found + [None] * (len(TURNS) - len(found))


def text(found):
    """Changes in per cent, as a cell of the table."""
    return ", ".join(
        "torn" if one is None else f"{100.0 * one[0]:+.2f} ({100.0 * one[1]:+.1f})" for one in found
    )


def main():
    table = Table("method", *(f"{cells} cells, {speed:g} c" for cells, speed in BLOCKS))
    for shape, configuration in METHODS:
        found = [text(changes(shape, configuration, *block)) for block in BLOCKS]
        initial = ", initial" * (configuration == "initial")
        table.add(f"{shape}, affine{initial}", *found)
    put({"turns": table.text()})
