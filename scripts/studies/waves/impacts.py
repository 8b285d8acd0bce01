"""Bars that meet: what is left of their speed, and of the last one's in a row of five."""

from studies.scenes import case_of, core, filled, finished

SPEED = 0.01  # over that of waves


def _run(bars, cells, mass, courant, gap):
    """Momenta and energies over those of the first bar, at the end and at the start.

    Young's modulus, density and cells are 1; `bars` are the velocities, over SPEED.
    """
    law = {"model": "linear-1d", "young": 1.0, "density": 1.0}
    bodies, low = {}, 3.3
    for n, v in enumerate(bars):
        bodies[f"bar{n}"] = (
            {"material": "bar", "formulation": "total-lagrangian"}
            | filled([low], [low + cells])
            | {"velocity": [v * SPEED]}
        )
        low += cells + gap
    end = 2.5 * cells * len(bars) + gap / SPEED * (len(bars) - 1)
    case = case_of([float(int(low) + 8)], 1.0, {"bar": law}, bodies, end, courant=courant,
                   method={"mass": mass}, contact=[{"bodies": "all"}])  # fmt: skip
    sim = core(case)
    first = sim.diagnostics()
    last = finished(sim).diagnostics()
    p = [last[f"body.{name}.momentum-x"] / (SPEED * cells) for name in bodies]
    energy = [line["kinetic-energy"] + line["strain-energy"] for line in (first, last)]
    return p, energy[1] / energy[0]


def rebound(cells, mass, courant=0.3):
    """Restitution of two equal bars, and what is left of their energy."""
    (a, b), energy = _run([1.0, -1.0], cells, mass, courant, 0.37)
    return 0.5 * (b - a), energy


def cradle(cells, mass, courant=0.3, bars=5):
    """Speed of the last of some bars, half a cell apart, of which the first hits the others."""
    p, energy = _run([1.0, *[0.0] * (bars - 1)], cells, mass, courant, 0.5)
    return p[-1], energy


def rows():
    """Rows of the table: part of the speed that is left, with lumped and with averaged mass."""
    for words, function, size in (
        *((f"two bars of {cells} cells", rebound, cells) for cells in (20, 40, 80)),
        ("the last of five bars of 40 cells", cradle, 40),
    ):
        for courant in (0.3, "auto"):
            found = [function(size, mass, courant) for mass in ("lumped", "averaged")]
            yield [words, f"`{courant}`", *(f"{speed:.4f}" for speed, _ in found),
                   *(f"{100.0 * (1.0 - energy):.1f} %" for _, energy in found)]  # fmt: skip
