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
        bodies[f"bar{n}"] = {"material": "bar", "configuration": "initial"} | filled(
            [low], [low + cells]
        ) | {"velocity": [v * SPEED]}
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


def rebound(cells, mass, courant=0.3, along=0.0):
    """Restitution of two equal bars that move together with a speed `along`, besides; energy."""
    (a, b), energy = _run([along + 1.0, along - 1.0], cells, mass, courant, 0.37)
    return 0.5 * (b - a), energy


def cradle(mass, cells=40, bars=5, gap=0.0, courant=0.3):
    """Speed of the last of some bars in touch, of which the first hits the others."""
    p, energy = _run([1.0, *[0.0] * (bars - 1)], cells, mass, courant, gap)
    return p[-1], energy
