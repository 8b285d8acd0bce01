"""Bodies pressed on each other at rest: uniform stress between lattices that differ, Hertz."""

from math import cos, pi, radians, sin, sqrt

import numpy as np
from studies.patches.impacts import SOLID, YOUNG, C, exact
from studies.scenes import ball, box, case_of, core

from pgimp.kernels.data.motion import DISPLACEMENT


def shifted(sim, beyond, way):
    """Move what is beyond a place along x by a vector before the first step."""
    grid, rows = sim.rank.grid, sim.live()
    first = int(np.ceil(beyond)) + sim.scene.domain.frame.ghost - grid.window.lower[0]
    kept = grid.by_vertex(grid.kept.values)[first:]
    there = rows[sim.particles.x[rows, 0] > beyond]
    for d, u in enumerate(way):
        kept[..., DISPLACEMENT + d] += u
        sim.particles.x[there, d] += u


def turned(middle, sides, angle):
    """Region of a rectangle, or a box, that is turned in the plane of x and y; its normals."""
    D, c, s = len(sides), cos(radians(angle)), sin(radians(angle))
    axes = np.eye(D)
    axes[:2, :2] = [[c, s], [-s, c]]
    planes = [
        {"half-space": {"point": (middle + 0.5 * way * side * axis).tolist(),
                        "normal": (way * axis).tolist()}}
        for axis, side in zip(axes, sides, strict=True) for way in (-1.0, 1.0)
    ]  # fmt: skip
    return {"intersection": planes}, axes


def patch_test(D, offset, angle, strain=2e-3, side=4.0, end=200.0):
    """Least and greatest stress over its mean, and rms, in two blocks whose lattices are apart.

    Rigid plates press them on each other along a direction that is turned by `angle`; nothing holds
    them sideways. Then all stresses are equal.
    """
    sides = np.array([side, 3.0, side][:D])
    axes = turned(np.zeros(D), sides, angle)[1]
    middle = np.full(D, 10.0) + np.array([0.11, 0.07, -2.69][:D])
    # Where the second lies on its lattice, and where it is.
    there = middle + 3.0 * axes[1]
    put = there + np.array([9.0 + offset[0], offset[1], 0.45][:D])
    soft = SOLID | {"model": "hooke", "young": 1.0}
    ramp = 0.3 * end
    bodies = {}
    for name, at, way in (("a", middle, -1.0), ("b", put, 1.0)):
        bodies[name] = exact(turned(at, sides, angle)[0])
        home = at if name == "a" else there
        plate = home + 2.5 * way * axes[1]
        speed = (-way * 3.0 * strain / ramp * axes[1]).tolist()
        table = [[0.0, speed], [ramp, speed], [ramp + 1.0, [0.0] * D]]
        bodies[f"plate-{name}"] = {
            "rigid": {"velocity": {"table": table}},
            "region": turned(plate, np.array([side + 3.0, 2.0, side + 3.0][:D]), angle)[0],
        }
    pairs = [["a", "b"], ["plate-a", "a"], ["plate-b", "b"]]
    case = case_of([28.0, 24.0, 14.0][:D], 1.0, {"solid": soft}, bodies, end,
                   damping={"mass": 0.2}, contact=[{"bodies": two} for two in pairs])  # fmt: skip
    sim = core(case)
    shifted(sim, 0.5 * (middle[0] + put[0]), there - put)
    while not sim.finished:
        sim.advance()
    p, rows = sim.particles, sim.live()
    sigma = p.sigma[rows]
    tensor = np.zeros((len(rows), 3, 3))
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    for n, (i, j) in enumerate(places[: sigma.shape[1]]):
        tensor[:, i, j] = tensor[:, j, i] = sigma[:, n]
    along = np.einsum("pij,i,j->p", tensor[:, :D, :D], axes[1], axes[1])
    share = p.V0[rows] / p.V0[rows].sum()
    along /= share @ along
    return along.min(), along.max(), sqrt(share @ (along - 1.0) ** 2)


def pressures(sim):
    """Patches under pressure: centroid in the initial state, area, force; of those that push."""
    contact = sim.rank.contact
    surface = contact._table.surface
    kept = contact._warm_start._kept
    patch = kept["vertex"][:, 0]
    area = np.bincount(surface.patch, surface.area)
    body = np.zeros(len(area), np.int64)
    body[surface.patch] = surface.body
    middle = np.stack(
        [np.bincount(surface.patch, surface.area * surface.x[:, d]) / area for d in range(3)], 1
    )
    return body[patch], middle[patch], area[patch], np.sqrt((kept["force"] ** 2).sum(axis=1))


def line(R, load=0.02, waves=60.0):
    """Greatest pressure over Hertz's, of a disk on a rigid plane under its weight, and more.

    Also the half width in cells, the force over the weight, and the rms deviation from his profile.
    """
    stiff = YOUNG / (1.0 - 0.3**2)
    force = load * stiff * R
    g = force / (pi * R * R)
    rate = C / R
    centre = np.array([R + 4.13, R + 4.21])
    floor = centre[1] - R - 1e-3
    bodies = {
        "disk": exact(ball(centre, R)),
        "floor": {"rigid": {}, "region": box([1.3, floor - 3.0], [2.0 * R + 7.7, floor])},
    }
    gravity = {"table": [[0.0, [0.0, 0.0]], [12.0 / rate, [0.0, -g]]]}
    size = np.ceil([2.0 * R + 9.0, 2.0 * R + 8.0])
    sim = core(case_of(size, 1.0, {"solid": SOLID}, bodies, waves / rate, gravity=gravity,
                       damping={"mass": 0.5 * rate},
                       contact=[{"bodies": ["disk", "floor"]}]))  # fmt: skip
    while not sim.finished:
        sim.advance()
    body, middle, area, pushed = pressures(sim)
    half = sqrt(4.0 * force * R / pi / stiff)
    top = 2.0 * force / pi / half
    own = body == 0
    x, found = middle[own, 0] - centre[0], pushed[own] / area[own]
    t = (np.arange(101) + 0.5) / 101.0 - 0.5
    hertz = top * np.array([
        np.sqrt(np.maximum(0.0, 1.0 - ((c + w * t) / half) ** 2)).mean()
        for c, w in zip(x, area[own], strict=True)
    ])  # fmt: skip
    on = found > 0.0
    return {
        "half width": half,
        "force": pushed.sum() / force,
        "greatest": found.max(initial=0.0) / top,
        "rms": sqrt(((found - hertz)[on] ** 2).mean()) / top if on.any() else np.nan,
    }
