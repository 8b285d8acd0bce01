"""Cylinders and spheres on slopes; angular momentum on the grid, and what particles keep of it."""

from math import cos, radians, sin

import numpy as np
from studies.contact import motion
from studies.scenes import ball, box, looked

import pgimp
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.data.record import MASS, MOMENTUM, RECORD, VELOCITY
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.time.clock import Step
from pgimp.solver.transfers import sum_particles
from pgimp.solver.vertices import fold_mirrors, vertex_update

#: Moment of inertia of a cylinder and of a sphere, over mass and radius squared.
INERTIA = {2: 0.5, 3: 0.4}
#: Height of the floor.
FLOOR = 0.4
#: Time in which the weight sets in.
RAMP = 1.0


def _floor(case, floor, friction, size):
    """Add a floor to a case with a body `wheel`: soft and held below, rigid, or the wall."""
    D = len(size)
    low, high = [0.0] * D, [*size[:-1], FLOOR]
    if floor == "wall":
        case["boundaries"] = {f"{'xyz'[D - 1]}-min": {"unilateral": {"friction": friction}}}
        return
    if floor == "rigid":
        far = box([-1.0] * D, [*[s + 1.0 for s in size[:-1]], FLOOR])
        case["bodies"]["floor"] = {"rigid": {}, "region": far}
    else:
        case["bodies"]["floor"] = {"material": "solid", "region": box(low, high)}
        case["boundaries"] = {f"{'xyz'[D - 1]}-min": "fixed", "x-min": "slip", "x-max": "slip"}
    case["contact"] = [{"bodies": ["floor", "wheel"], "friction": friction}]


def _motion_of(simulation, D):
    """Velocity along the slope and rate of turning of the wheel."""
    particles = simulation.particles
    own = particles["body"] == list(simulation.case.bodies).index("wheel")
    x, v, m = (particles[name][own] for name in ("position", "velocity", "mass"))
    mean = (m @ v) / m.sum()
    x, v = x - (m @ x) / m.sum(), v - mean
    up = D - 1
    spin = (m * (x[:, up] * v[:, 0] - x[:, 0] * v[:, up])).sum()
    return mean[0], spin / (m * (x[:, up] ** 2 + x[:, 0] ** 2)).sum()


def slope(dimensions, cell, angle, friction, floor, young=None):
    """A cylinder or sphere with a radius of 1 on a slope: acceleration, and that of its spin.

    Both over those of a rigid one, which rolls if friction is more than tan/(1 + 1/k), with the
    inertia k M R^2: g sin/(1 + k), and g sin/(1 + k)/R. Else it slips: g (sin - mu cos), and
    mu g cos/(k R). Velocities are fitted by lines between two times, as bodies rock on what they
    lie on; they would do so much more, for a while, if the weight did not set in gradually.
    """
    D, g, k = dimensions, 1.0, INERTIA[dimensions]
    s, c = sin(radians(angle)), cos(radians(angle))
    rolls = friction >= s / c / (1.0 + 1.0 / k)
    times = (1.5, 3.5) if D == 3 else ((2.5, 8.5) if rolls else (1.5, 4.5))
    exact = (g * s / (1.0 + k),) * 2 if rolls else (g * (s - friction * c), friction * g * c / k)
    way = 0.5 * exact[0] * (times[1] - 0.5 * RAMP) ** 2
    low = 0.0 if floor == "wall" else FLOOR
    size = [np.ceil(2.6 + way), *[2.8] * (D - 2), low + 2.2]
    centre = [1.3, *[1.4] * (D - 2), low + 1.0]
    bodies = {"wheel": (ball(centre, 1.0), [0.0] * D)}
    size = [round(float(n) / cell) * cell for n in size]
    weight = [g * s, *[0.0] * (D - 2), -g * c]
    gravity = {"table": [[0.0, [0.0] * D], [RAMP, weight]]}
    solid = motion.SOLID | {"young": young or (1000.0 if D == 2 else 300.0)}
    case = motion.case_of(
        bodies, size, cell, times[1], solid,
        gravity=gravity, method={"affine": True}, output={"fields": ["velocity", "mass"]},
    )  # fmt: skip
    _floor(case, floor, friction, size)
    found, _, _ = looked(case, np.linspace(*times, 61), lambda sim: (sim.time, *_motion_of(sim, D)))
    time, velocity, spin = np.transpose(found)
    return tuple(
        np.polyfit(time, values, 1)[0] / one
        for values, one in ((velocity, exact[0]), (spin, exact[1]))
    )


def at_vertices(simulation, dt):
    """Change of momentum and of its moment on the grid in the next step, without doing it.

    Returns the change of (momentum, angular momentum) along and about x, y, z in a step, and what
    they are.
    """
    rank = simulation.core.rank
    scene, grid = rank.scene, rank.grid
    t = Step(1, simulation.time, dt, simulation.time + dt)
    rank.contact.assign_fields(rank)
    parts = groups_of(rank)
    sum_particles(rank, parts, scene.interaction.loads.at(t.start), marked=False)
    rank.halo.finish(grid)
    scratch = Ledger(*map(np.zeros_like, rank.ledger))
    rank.contact.detect(rank, t, scratch)
    update = vertex_update(rank, t, scene.interaction.loads.at(t.start), scratch)
    fold_mirrors(rank, update)
    window, frame, D = grid.window, scene.domain.frame, scene.dimension
    fields = 1 + max(grid.fields, default=0)
    shape = (grid.planes, fields, *window.extent[1:], RECORD)
    active = grid.active > 0
    place = np.zeros((*shape[:-1], 3))
    for d, axis in enumerate((0, 2, 3)[:D]):
        count = shape[axis]
        along = frame.origin[d] + frame.cell[d] * (np.arange(count) + window.lower[d] - frame.ghost)
        place[..., d] = along.reshape([-1 if a == axis else 1 for a in range(4)])

    def sums(momentum):
        moment = np.cross(place[active], momentum)
        axes = (0, 1, 2, 3)
        return np.concatenate([momentum.sum(axis=axes), moment.sum(axis=axes)])

    G = grid.G.reshape(shape)
    before = G[active][..., MOMENTUM : MOMENTUM + 3].copy()
    rank.contact.update_momentum(rank, update)
    mass, velocity = G[active][..., MASS, None], G[active][..., VELOCITY : VELOCITY + 3]
    after = np.where(mass > 0.0, mass * velocity, 0.0)
    return sums(after) - sums(before), sums(before)


def collision(dimensions, cell, affine=False):
    """Free blocks that meet askew with friction: what is not kept of momenta.

    Greatest change in a step, on the grid, of the angular momentum; change of that of the
    particles from beginning to end; change of their momentum. In parts of the momentum of a block
    times, but for the last, its size.
    """
    D = dimensions
    low, high = [1.5] * D, [4.5] * D
    bodies = {
        "a": (box(low, high), [2.0, 0.7, -0.3][:D]),
        "b": (box([5.0, *[2.5] * (D - 1)], [8.0, *[5.5] * (D - 1)]), [-1.0, 0.1, 0.4][:D]),
    }
    case = motion.case_of(
        bodies, [10.0, 8.0, 8.0][:D], cell, 1.0, contact=[{"bodies": "all", "friction": 0.5}],
        method={"affine": affine},
    )  # fmt: skip
    simulation = pgimp.Simulation(case)
    first = simulation.diagnostics()
    scale, worst = 3.0**D * 2.1, 0.0
    while not simulation.finished:
        simulation.step()
        if simulation.steps % 5 == 0:
            change, _ = at_vertices(simulation, simulation.dt)
            worst = max(worst, np.abs(change[3:]).max())
    last = simulation.diagnostics()

    def changed(what):
        names = [name for name in first if name.startswith(what)]
        return max(abs(last[name] - first[name]) for name in names)

    return (
        worst / (3.0 * scale), changed("angular-momentum-") / (3.0 * scale),
        changed("momentum-") / scale,
    )  # fmt: skip
