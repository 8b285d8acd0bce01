"""The block that most benchmarks run: it falls freely, so that its exact motion is known.

Whatever its particles have of stress, or of velocity differences, is error.
"""

from statistics import median

import numpy as np
from workers.clock import clock

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.solver.setup import put_in_order
from pgimp.solver.simulation import Simulation

YOUNG, POISSON, DENSITY, GRAVITY, SPEED = 1.0e6, 0.3, 1000.0, -9.81, 0.1
COURANT = 0.2
#: Empty cells on either side of the block.
PAD = 4
MATERIALS = {
    "linear-1d": {"model": "linear-1d", "young": YOUNG, "density": DENSITY},
    "hooke": {"model": "hooke", "young": YOUNG, "poisson": POISSON, "density": DENSITY},
    "neo-hookean": {"model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": DENSITY},
}
#: Phases of the tables, and the simulation's phases that each sums.
PHASES = {
    "P2G": ("P2G",), "grid": ("momentum",), "G2P": ("G2P",), "order": ("order", "sort"),
    "exchange": ("exchange", "migrate"),
}  # fmt: skip


def lame():
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    return YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)), shear


def step_of(cell):
    """Time step of all blocks, and of their peers: the wave crosses a fifth of a cell."""
    first, shear = lame()
    return COURANT * cell / float(np.sqrt((first + 2.0 * shear) / DENSITY))


def block(cells, per_cell=2, shape="gimp", material=None, pad=PAD, method=None, **parts):
    """The case of a block of unit height in free fall.

    One of a unit has as many `cells` as the last direction; beyond its ends are `pad` empty cells,
    one number or a pair for each direction. `method` has further keys of ``method``, `parts` of
    the case, or other values of them.
    """
    D, h = len(cells), 1.0 / cells[-1]
    material = material or ("linear-1d" if D == 1 else "neo-hookean")
    pads = [(pad, pad)] * D if isinstance(pad, int) else list(pad)
    size = [h * (n + below + above) for n, (below, above) in zip(cells, pads, strict=True)]
    low = [h * below for below, _ in pads]
    high = [h * (n + below) for n, (below, _) in zip(cells, pads, strict=True)]
    dt = step_of(h)
    return {
        "format": 1, "title": "Block in free fall", "dimensions": D,
        "grid": {"origin": [0.0] * D, "size": size, "cell": [h] * D},
        "method": {"shape": shape, "particles-per-cell": [per_cell] * D, **(method or {})},
        "time": {"end": 100_000 * dt, "step": dt}, "materials": {"solid": MATERIALS[material]},
        "bodies": {"block": {
            "material": "solid", "region": {"box": {"min": low, "max": high}},
            "velocity": start_velocity(D),
        }},
        "gravity": [0.0] * (D - 1) + [GRAVITY],
    } | parts  # fmt: skip


def start_velocity(dimension):
    """Velocity of the block at the beginning."""
    return [SPEED] + [0.0] * (dimension - 1)


def uniform(ids, dimension):
    """Numbers in [0, 1) from each id, (n, D), independent of the ranks (splitmix64)."""
    numbers = []
    for d in range(dimension):
        z = ids.astype(np.uint64) * np.uint64(dimension) + np.uint64(d)
        z *= np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        numbers.append((z ^ (z >> np.uint64(31))) >> np.uint64(11))
    return np.stack(numbers, axis=1).astype(float) * 2.0**-53


def shake(sim):
    """Move the particles to random places, so that they stay on their rank.

    Along x they stay in their layer, across it in their cell; points (mpm) in the middle half of
    it, because a vertex that is almost out of a point's reach makes any solid unstable.
    """
    p, frame, rows = sim.particles, sim.scene.domain.frame, sim.live()
    half = sim.scene.settings.shape.half[0]
    cell, origin = np.array(frame.cell), np.array(frame.origin)
    corner = np.floor((p.x[rows] - origin) / cell)
    corner[:, 0] = p.layer[rows] - frame.ghost + half
    places = uniform(p.id[rows], len(cell))
    if half == 0.0:
        places = 0.25 + 0.5 * places
    p.x[rows] = origin + (corner + places) * cell
    start = sim.now_as_start()
    put_in_order(start, sim.rank.slab, p, len(rows), sim.count)
    sim.take(start)


def create(case, comm=None, random=False):
    """The simulation of a block, its particles on a lattice or at random places; collective."""
    sim = Simulation(Case.model_validate(case), comm or Serial())
    if random:
        shake(sim)
    return sim


def errors(sim):
    """Greatest errors of velocity, over the speed, and stress, over Young's modulus; collective."""
    rows, D = sim.live(), sim.scene.dimension
    v = np.array(start_velocity(D))
    v[-1] += GRAVITY * sim.time
    velocity = np.abs(sim.particles.v[rows] - v).max(initial=0.0) / np.linalg.norm(v)
    stress = np.abs(sim.particles.sigma[rows]).max(initial=0.0) / YOUNG
    every = np.array(sim.comm.allgather((float(velocity), float(stress))))
    return float(every[:, 0].max()), float(every[:, 1].max())


class Timed:
    """A simulation that is timed in rounds of steps, by turns with others; collective.

    `after` is called after each step. Of each round there are the seconds, and by phase the wall
    time of the slowest rank.
    """

    def __init__(self, sim, steps, after=None):
        self.sim, self.steps, self._after = sim, steps, after
        self.seconds = []
        self.phases = []
        self._advance()  # touches the memory
        self.seconds.clear()
        self.phases.clear()

    def _advance(self):
        sim = self.sim
        before = dict(sim.rank.timings)
        sim.comm.Barrier()
        began = clock()
        for _ in range(self.steps):
            sim.advance(complete=False)
            if self._after:
                self._after()
        sim.complete_reduction()
        sim.comm.Barrier()
        self.seconds.append(clock() - began)
        spent = {
            name: sum(sim.rank.timings[part] - before[part] for part in parts if part in before)
            for name, parts in PHASES.items()
        }
        every = sim.comm.allgather(spent)
        self.phases.append({name: max(one[name] for one in every) for name in PHASES})

    def round(self):
        self._advance()

    @property
    def speeds(self):
        """Million particle-steps/s of each round."""
        return [self.sim.count * self.steps / s / 1e6 for s in self.seconds]

    def phase_speed(self, name):
        """Median of the million particle-steps/s of a phase alone; None if it takes no time."""
        spent = median(one[name] for one in self.phases)
        return self.sim.count * self.steps / spent / 1e6 if spent > 0.0 else None

    def result(self, **more):
        """What a table says of it: particles, speeds, `more`, and errors; collective."""
        velocity, stress = errors(self.sim)
        return {
            "particles": self.sim.count, "speed": median(self.speeds), "speeds": self.speeds,
            **more, "velocity": velocity, "stress": stress,
        }  # fmt: skip
