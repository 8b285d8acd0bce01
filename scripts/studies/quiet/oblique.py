"""What comes back from an absorbing face, by the angle from its normal.

A pulse spreads from a point before the face. The same pulse in ground without end is taken away
from it: what is left has come back, as if from the image of the point. Its amplitude is compared
with that of the pulse without end at the same distance in the same direction.
"""

from math import radians, tan

import numpy as np
from studies.scenes import box, case_of, core, throw

#: Cells from the point to the face, and to the edges of what has none.
AHEAD, FREE = 25, 120
#: Radius of the pulse at the beginning, in cells; it grows to about 12 cells from end to end.
RADIUS = 3.0
ANGLES = (2, 15, 30, 45, 55)
YOUNG, POISSON = 1.0, 0.25
SPEED = {
    "compression": (YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))) ** 0.5,
    "shear": (0.5 * YOUNG / (1 + POISSON)) ** 0.5,
}


def spread(wave, ahead, configuration):
    """Positions from the point, times and velocities, particle by particle, of a pulse."""
    size, point = [2.0 * FREE, ahead + FREE], np.array([FREE, ahead])
    case = case_of(
        size, 1.0, {"m": {"model": "hooke", "young": YOUNG, "poisson": POISSON, "density": 1.0}},
        {"b": {"material": "m", "formulation": configuration, "region": box([0.0, 0.0], size)}},
        2.0 * FREE / SPEED[wave], boundaries={"y-min": "absorbing"},
    )  # fmt: skip
    sim = core(case)
    r = sim.particles.x[sim.live()] - point
    bell = np.exp(-np.einsum("ni,ni->n", r, r) / RADIUS**2)[:, None]
    along = r if wave == "compression" else r[:, ::-1] * [-1.0, 1.0]
    turn = np.eye(2) if wave == "compression" else np.array([[0.0, -1.0], [1.0, 0.0]])
    outer = np.einsum("ni,nj->nij", along, -2.0 * r / RADIUS**2)
    throw(sim, 1e-6 * along * bell, 1e-6 * bell[:, :, None] * (turn + outer))
    targets = [(AHEAD * 2.0 * tan(radians(a)), side) for a in ANGLES for side in (0, 2 * AHEAD)]
    found, times = {target: [] for target in targets}, []
    # Order changes from step to step: particles are found again by their ids.
    cells = [np.abs(r - target).max(axis=1) < 1.0 for target in targets]
    ids = [sim.particles.id[sim.live()][near] for near in cells]
    longest = max(np.hypot(*target) for target in targets)
    while sim.time * SPEED[wave] < longest + 4.0 * RADIUS:
        sim.advance()
        times.append(sim.time)
        v = np.empty((len(sim.live()), 2))
        v[sim.particles.id[sim.live()]] = sim.particles.v[sim.live()]
        for target, near in zip(targets, ids, strict=True):
            found[target].append(v[near].mean(axis=0))
    return np.array(times), {target: np.array(values) for target, values in found.items()}


def returned(wave, configuration="current"):
    """Amplitude that comes back over the one that arrives, for each of `ANGLES`."""
    times, far = spread(wave, FREE, configuration)
    other, near = spread(wave, AHEAD, configuration)
    parts = []
    for angle in ANGLES:
        across = AHEAD * 2.0 * tan(radians(angle))
        ray = np.array([across, 2.0 * AHEAD])
        distance = np.hypot(*ray)
        side = ray / distance if wave == "compression" else np.array([-ray[1], ray[0]]) / distance
        steps = min(len(times), len(other))
        np.testing.assert_array_equal(times[:steps], other[:steps])
        here = np.abs(times[:steps] * SPEED[wave] - distance) < 3.0 * RADIUS
        back = (near[across, 0] - far[across, 0])[:steps][here] @ side
        arrives = far[across, 2 * AHEAD][:steps][here] @ side
        parts.append(np.abs(back).max() / np.abs(arrives).max())
    return parts


def plane(wave):
    """Amplitude of a plane wave of the same kind that comes back, by the dashpots' own law.

    At the face tractions are rho c v, of compression across it and of shear along it. Both waves
    that come back are unknown; the one along the wave's own polarisation is returned.
    """
    mu, speeds = SPEED["shear"] ** 2, list(SPEED.values())
    lam, own = SPEED["compression"] ** 2 - 2.0 * mu, [*SPEED].index(wave)

    def misfit(kind, slowness, side):
        k = np.array([slowness, side * np.sqrt(complex(1.0 / speeds[kind] ** 2 - slowness**2))])
        v = speeds[kind] * (k if kind == 0 else np.array([-k[1], k[0]]))
        strain = -0.5 * (np.outer(v, k) + np.outer(k, v))
        stress = lam * np.trace(strain) * np.eye(2) + 2.0 * mu * strain
        return np.array([stress[0, 1] + speeds[1] * v[0], stress[1, 1] + speeds[0] * v[1]])

    parts = []
    for angle in ANGLES:
        slowness = np.sin(radians(angle)) / speeds[own]
        back = np.stack([misfit(kind, slowness, -1.0) for kind in (0, 1)], axis=1)
        parts.append(abs(np.linalg.solve(back, -misfit(own, slowness, 1.0))[own]))
    return parts
