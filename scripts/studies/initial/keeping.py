"""What is measured of the two configurations, each on one rank."""

from itertools import pairwise
from math import cos, cosh, log, pi, sin, sinh, sqrt

import numpy as np
from studies.scenes import ball, by_id, by_turns, case_of, core, filled, finished, throw

import pgimp
from pgimp.errors import RunError
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation
from pgimp.utilities.model.block import Block, block_case

#: A steel-like ratio, and waves at 1.16 sqrt(E/rho).
YOUNG, POISSON, DENSITY = 1.0e6, 0.3, 1000.0
WAVE = sqrt(YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)) / DENSITY)
#: The cantilever of 4 by 1, its first mode after Euler and Bernoulli, and what its tip reaches.
LENGTH, HEIGHT, TIP = 4.0, 1.0, 0.02
ROOT = 1.8751040687
RATE = ROOT**2 * sqrt(YOUNG / (1.0 - POISSON**2) / DENSITY / 12.0) * HEIGHT / LENGTH**2
PERIOD = 2.0 * pi / RATE
#: Instants at which it is looked at, in a period of that; its own period is 1.05 of them.
LOOKS = 40
#: When the tip of the hanging cube is looked at; finite elements have it 1.738 m below then.
CUBE = 0.0882


def simulation(size, cell, body, time, configuration, method=None, density=DENSITY, **changes):
    """A neo-Hookean body of two particles a cell and direction."""
    jelly = {"model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": density}
    bodies = {"body": {"material": "jelly", "formulation": configuration} | body}
    changes |= {"time": time, "method": method or {}}
    return core(case_of(size, cell, {"jelly": jelly}, bodies, time["end"], **changes))


def _mode(x):
    """Deflection and slope of the first mode at x, 1 at the tip."""
    b = ROOT / LENGTH
    k = (cosh(ROOT) + cos(ROOT)) / (sinh(ROOT) + sin(ROOT))
    z = b * x
    value = np.cosh(z) - np.cos(z) - k * (np.sinh(z) - np.sin(z))
    slope = b * (np.sinh(z) + np.sin(z) - k * (np.cosh(z) - np.cos(z)))
    return 0.5 * value, 0.5 * slope


def ringing(configuration, affine, courant, cells=16, periods=(10, 50), shape="gimp"):
    """Modal energy that is left after some periods, over that of the first; the period.

    The beam begins in its first mode. Its energy is the square of the greatest projection of the
    velocity onto that mode in a period: what has gone into other modes does not count.
    """
    h = LENGTH / cells
    each = -(-int(PERIOD / LOOKS * WAVE * 1000) // int(courant * h * 1000))
    dt = PERIOD / LOOKS / each
    looks = int(max(periods) * LOOKS * 1.08)
    y = 3.0 * h + 0.5 * HEIGHT
    body = filled([0.0, 3.0 * h], [LENGTH, 3.0 * h + HEIGHT])
    sim = simulation(
        [LENGTH + 4.0 * h, HEIGHT + 8.0 * h], h, body, {"end": dt * each * looks, "step": dt},
        configuration, {"shape": shape, "affine": affine}, boundaries={"x-min": "fixed"},
    )  # fmt: skip
    p, rows = sim.particles, sim.live()
    mode, slope = _mode(p.x[rows, 0])
    speed = TIP * LENGTH * RATE
    L = np.zeros((len(rows), 2, 2))
    L[:, 0, 1], L[:, 1, 0] = -speed * slope, speed * slope
    throw(sim, speed * np.stack([-slope * (p.x[rows, 1] - y), mode], axis=1), L)
    mode = by_id(sim, mode)
    motion = []
    for _ in range(looks):
        for _ in range(each):
            sim.advance()
        p, rows = sim.particles, sim.live()
        motion.append(float((p.m[rows] * p.v[rows, 1]) @ mode[p.id[rows]]))
    q, window = np.array(motion), int(1.05 * LOOKS)
    peaks = np.abs(q[: len(q) // window * window]).reshape(-1, window).max(axis=1)
    rising = np.flatnonzero((q[:-1] < 0.0) & (q[1:] >= 0.0))
    zeros = rising - q[rising] / (q[rising + 1] - q[rising])
    return {
        "left": {str(n): float((peaks[n - 1] / peaks[0]) ** 2) for n in periods},
        "period": float(np.diff(zeros).mean() / LOOKS),
        "courant": dt * WAVE / h,
    }


def spin(configuration, affine, cells=8, courant=0.4):
    """Part of its angular momentum that a square loses in 3.2 turns."""
    motion = {"rotation": {"about": [1.5, 1.5], "rate": 1.0}}
    body = filled([1.0, 1.0], [2.0, 2.0]) | {"velocity": motion}
    sim = simulation([3.0, 3.0], 1.0 / cells, body, {"end": 20.0, "step": {"courant": courant}},
                     configuration, {"affine": affine}, density=1550.0)  # fmt: skip
    first = sim.diagnostics()["angular-momentum-z"]
    finished(sim)
    return {"lost": 1.0 - sim.diagnostics()["angular-momentum-z"] / first, "steps": sim.step}


def stretch(shape, even):
    """A bar between two grips is pulled to five times its length: how evenly, with what force.

    `even` lets it begin in the velocities of even stretch, so that there are no waves.
    """
    speed = 5.0
    grips = {"left": (49.0, 50.0, -speed), "right": (90.0, 91.0, speed)}
    held = {
        name: {"body": "body", "velocity": [v]} | filled([a], [b])
        for name, (a, b, v) in grips.items()
    }
    sim = core(case_of(
        [140.0], 1.0, {"bar": {"model": "linear-1d", "young": 1.0e6, "density": 1.0}},
        {"body": {"material": "bar", "formulation": "total-lagrangian"} | filled([49.0], [91.0])},
        16.0,
        method={"shape": shape}, constraints=held,
    ))  # fmt: skip
    p, rows = sim.particles, sim.live()
    if even:
        x = (p.x[rows] - 70.0) / 20.0
        L = np.where(abs(x) < 1.0, speed / 20.0, 0.0)[..., None]
        throw(sim, np.clip(x, -1.0, 1.0) * speed, L)
    finished(sim)
    free = rows[p.constraint[rows, 0] == 0]
    F, s = p.F[free, 0], p.sigma[free, 0]
    return {"F": float(np.abs(F - 5.0).max()), "force": float(np.abs(s / 4.0e6 - 1.0).max())}


def vortex(configuration, amplitude, cell, shape="gimp", affine=False):
    """Greatest error of the displacement over time, root mean square, and when it stopped."""
    jelly = {"model": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1000.0}
    region = {"difference": [ball([0.0, 0.0], r) for r in (1.25, 0.75)]}
    ring = {"material": "jelly", "formulation": configuration, "region": region}
    steps = round(1.0 / (4.0e-3 * cell / 0.05))
    sim = core(case_of(
        [2.6, 2.6], cell, {"jelly": jelly}, {"ring": ring}, 1.0, grid={"origin": [-1.3, -1.3]},
        method={"shape": shape, "affine": affine}, time={"step": 1.0 / steps},
        exact={"generalized-vortex": {"amplitude": amplitude, "period": 2.0}},
    ))  # fmt: skip
    found, stopped = {}, None
    try:
        for part in (1, 2):
            while sim.time < 0.5 * part - 1e-9:
                sim.advance()
            line = sim.diagnostics()
            found[str(0.5 * part)] = line["error.displacement-l2"]
    except RunError:
        stopped = sim.time
    return {"error": found, "stopped": stopped}


def cube(configuration, D, cells, shape="gimp"):
    """Place of the tip, at `CUBE`, of a cube that begins to hang from rollers by its weight."""
    top, side = 4.0, 1.0
    low = [0.5] * D
    low[-1] = top - side
    size = [2.0] * D
    size[-1] = top
    gravity = [0.0] * D
    gravity[-1] = -1000.0
    face = f"{'xyz'[D - 1]}-max"
    sim = simulation(size, 1.0 / cells, filled(low, [a + side for a in low]),
                     {"end": 0.25, "step": {"courant": 0.3}}, configuration,
                     {"shape": shape}, density=1050.0,
                     gravity=gravity, boundaries={face: "slip"})  # fmt: skip
    p, rows = sim.particles, sim.live()
    first = p.x[rows].copy()
    bottom = first[:, -1] < top - side + 0.6 / cells
    ids = p.id[rows[bottom]]
    half = 0.25 / cells
    times, tips = [0.0], [0.0]
    try:
        while sim.time < CUBE:
            sim.advance()
            p, rows = sim.particles, sim.live()
            of = np.flatnonzero(np.isin(p.id[rows], ids))
            of = rows[of]
            # The face is half a particle's spacing below the outermost centres, and stretched.
            stretch = p.F[of, -1]
            tip = (p.x[of, -1] - half * stretch).mean() - (top - side)
            times.append(sim.time)
            tips.append(float(tip))
    except RunError as error:
        return {"tip": None, "time": sim.time, "stopped": str(error).splitlines()[0]}
    return {"tip": float(np.interp(CUBE, times, tips)), "stopped": None}


def hourglass(per_cell, cells=10):
    """Hourglass displacements over those that strain, of a square thrown on a rigid disk, by time.

    They are root mean squares over its cells of patterns of the corners' displacements. The times
    are 4, 8, 12 and 16 times a wave's way through the square.
    """
    h, size = 0.1, 0.1 * cells
    end = 17.0 * size / WAVE
    body = filled([3.0 * h, 6.0 * h], [3.0 * h + size, 6.0 * h + size])
    region = ball([3.0 * h + 0.5 * size, 3.0 * h], 2.9 * h)
    disk = {"region": region, "rigid": {"velocity": [0.0, 0.0]}}
    jelly = {"model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": DENSITY}
    body |= {"material": "jelly", "formulation": "total-lagrangian", "velocity": [0.0, -0.1 * WAVE]}
    case = case_of(
        [size + 6.0 * h, size + 10.0 * h], h, {"jelly": jelly}, {"body": body, "disk": disk}, end,
        time={"end": end, "step": {"courant": 0.3}}, contact=[{"bodies": "all"}],
    )  # fmt: skip
    model = pgimp.load(case)
    few = model.method.model_copy(update={"particles-per-cell": (per_cell,) * 2})
    sim = Simulation(model.model_copy(update={"method": few}), Serial())
    found = {}
    while not sim.finished:
        sim.advance()
        if sim.time >= 4.0 * (1 + len(found)) * size / WAVE:
            found[f"{4 * (1 + len(found))}"] = _alternating(sim.rank.grid)
    return found


def _alternating(grid):
    motion = grid.by_vertex(grid.motion.values)[:, 0, :, 0]
    u, there = motion[..., 1:3], motion[..., 0] > 0.0
    corners = [(slice(i, i - 1 or None), slice(j, j - 1 or None)) for i in (0, 1) for j in (0, 1)]
    a, b, c, d = (u[corner] for corner in corners)
    whole = np.all([there[corner] for corner in corners], axis=0)
    square = [
        (part[whole] ** 2).sum(axis=-1).mean()
        for part in (a - b - c + d, d + c - a - b, d - c + b - a)
    ]
    return sqrt(square[0] / (square[1] + square[2]))


def speed(D, kind, rounds=15, steps=12):
    """CPU time of a step in the current over that in the initial configuration, by turns.

    The standard block of `pgimp bench`, or a square: ``at rest`` as it lies on the lattice;
    ``moving`` at a twentieth of the wave speed, from where it is a third of a cell away on; with
    ``mean`` dilatation; of ``metal``, with a memory; or its particles at ``random`` places.
    """
    sims = {}
    for configuration in ("current", "initial"):
        case = block_case(32, 10**6)
        if D == 2:
            case["dimensions"] = 2
            case["gravity"] = case["gravity"][1:]
            h = case["grid"]["cell"][0]
            case["grid"] = {"size": [264.0 * h] * 2, "cell": [h] * 2}
            case["method"]["particles-per-cell"] = [2, 2]
        body = case["bodies"]["block"]
        body["formulation"] = configuration
        if D == 2:
            body |= filled([4.0 * h] * 2, [260.0 * h] * 2) | {"velocity": body["velocity"][:2]}
        if kind == "moving":
            dt = case["time"]["step"] = 1.5 * case["time"]["step"]  # a Courant number of 0.3
            case["time"]["end"] = 10**6 * dt
            pace = 0.05 * 0.3 * case["grid"]["cell"][0] / dt
            body["velocity"] = [pace] * D
        if kind == "mean":
            case["method"]["volumetric"] = "b-bar"
        if kind == "metal":
            (law,) = case["materials"].values()
            law |= {"model": "von-mises", "yield-stress": 0.01 * law["young"]}
        sim = Block(pgimp.load(case), Serial()) if kind == "random" else core(case)
        for _ in range(22 if kind == "moving" else 0):
            sim.advance()
        sims[configuration] = sim
    current, initial = by_turns(sims.values(), rounds, steps)[1:].T
    count = sims["initial"].count / 1e6
    return {
        "ratio": float(np.median(current / initial)),
        "million particle-steps/s": {
            "current": float(count / np.median(current)),
            "initial": float(count / np.median(initial)),
        },
    }


def order(errors):
    """Order of convergence of errors by cell size, each half as large as the one before."""
    return [log(a / b, 2.0) if a and b else None for a, b in pairwise(errors)]
