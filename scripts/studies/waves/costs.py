"""What a wave costs for an error of 1 %, and what averaged mass and cut cells cost a step."""

import numpy as np
from studies.scenes import by_turns, case_of, core, filled
from studies.waves import dispersion

#: Error to which cells are chosen, and waves along the cube that one crosses.
ERROR, WAVES = 0.01, 3
COURANT, ROUNDS = 0.3, 9
#: Where the lower corner of blocks that the grid cuts is in its cell.
SHIFT = (0.37, 0.21, 0.44)


def block(D, cells, shift=(0.0, 0.0, 0.0), surface="cut-particles", mass="lumped"):
    """A simulation of a free block with so many cells along each direction."""
    low = [4.0 + s for s in shift[:D]]
    law = {"model": "neo-hookean", "young": 1.0, "poisson": dispersion.RATIO, "density": 1.0}
    body = {"material": "solid", "formulation": "total-lagrangian", "velocity": [1e-3] * D}
    body |= filled(low, [each + cells for each in low])
    body["surface"] = surface
    dt = COURANT / dispersion.speeds(D)[-1]
    case = case_of([cells + 9.0] * D, 1.0, {"solid": law}, {"body": body}, 1.0,
                   method={"mass": mass})  # fmt: skip
    case["time"] = {"end": 1e6 * dt, "step": dt}
    return core(case)


def cells_of(part):
    """Cells that a wave in 3D needs, and the errors of P and S waves then."""
    for cells in range(4, 40):
        errors = np.sqrt((dispersion.Errors("gimp", 3, 2, (cells,))(part, COURANT) ** 2).mean(0))
        if (errors < ERROR).all():
            return cells, errors
    raise AssertionError


def waves(rounds=ROUNDS):
    """Rows of error beside time, lumped mass first."""
    found = {mass: cells_of(part) for mass, part in
             (("lumped", 0.0), ("averaged", dispersion.part("gimp", 3, 2, COURANT)))}  # fmt: skip
    sims = [block(3, WAVES * cells, mass=mass) for mass, (cells, _) in found.items()]
    seconds = by_turns(sims, rounds, 10)
    times = seconds * [WAVES * cells / COURANT for cells, _ in found.values()]
    shares = np.median(times / times[:, :1], axis=0)
    for (mass, (cells, errors)), sim, own, share in zip(
        found.items(), sims, times.T, shares, strict=True
    ):
        *shear, pressure = (f"{100.0 * each:.2f}" for each in errors)
        yield [mass, cells, f"{sim.count:,}", f"{pressure}, {max(shear)}",
               f"{np.median(own):.2g}", f"{share:.2g}"]  # fmt: skip


def steps(rounds=ROUNDS):
    """Rows of the speed of steps over that with lumped mass, and with surfaces that are cut."""
    for D, cells in ((2, 512), (3, 64)):
        sims = [block(D, cells, mass=mass) for mass in ("lumped", "averaged")]
        yield [f"{D}D, `mass: averaged` over `lumped`", *_share(sims, rounds)]
    for D, cells in ((2, 256), (3, 40)):
        sims = [block(D, cells, SHIFT, surface) for surface in ("boxes", "cut")]
        yield [f"{D}D, cut cells over boxes", *_share(sims, rounds)]


def _share(sims, rounds):
    seconds = by_turns(sims, rounds, 6)
    share = seconds[:, 0] / seconds[:, 1]
    speed = 1e-6 * sims[1].count / np.median(seconds[:, 1])
    return f"{sims[1].count:,}", f"{speed:.0f}", f"{np.median(share):.2f}"
