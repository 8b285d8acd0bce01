"""Bodies pressed on each other at rest: uniform stress between lattices that differ, Hertz."""

from math import cos, pi, radians, sin, sqrt

import numpy as np
from studies.patches.impacts import SOLID, YOUNG, C, exact
from studies.scenes import ball, box, case_of, core

from pgimp.jit.bound import Bound
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.solver.contact.surfaces.loads import Smoothed, smooth


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


def pressures(sim, body=0):
    """Patches of a body: centroids in the initial state, areas, forces, and these recovered.

    What is recovered has the same sum and first moment, as in frames of surfaces.
    """
    contact = sim.rank.contact
    surface, kept = contact._table.surface, contact._warm_start._kept
    pushed = np.zeros(1 + surface.patch.max())
    np.add.at(pushed, kept["vertex"][:, 0], np.sqrt((kept["force"] ** 2).sum(axis=1)))
    own = surface.body == body
    first, of = np.unique(surface.patch[own], return_inverse=True)
    area = np.bincount(of, surface.area[own])
    middle, normal = (
        np.stack([np.bincount(of, surface.area[own] * v) / area for v in each[own].T], axis=1)
        for each in (surface.x, surface.normal)
    )
    normal /= np.sqrt((normal**2).sum(axis=1))[:, None]
    facets = Smoothed(middle, normal, area, np.zeros(len(area), np.int64))
    force = pushed[first]
    smoothed = smooth(Bound(), facets, force[:, None], 1.0, sim.scene.dimension)[:, 0]
    return middle, area, force, smoothed


def pressed(bodies, size, D, rate, g, end, **more):
    """A solver at rest, after weight along the last axis has come slowly."""
    weight = [[0.0, [0.0] * D], [12.0 / rate, [0.0] * (D - 1) + [-g]]]
    sim = core(case_of(np.ceil(size), 1.0, {"solid": SOLID}, bodies, end,
                       gravity={"table": weight}, damping={"mass": 0.5 * rate},
                       contact=[{"bodies": [*bodies]}], **more))  # fmt: skip
    while not sim.finished:
        sim.advance()
    return sim


def line(R, at=(0.13, 0.21), load=0.02, waves=60.0):
    """Pressures over Hertz's greatest, of a disk on a rigid plane under its weight, and more.

    `at` is where its centre is in a cell.

    Also the half width in cells, the force over the weight, and the rms deviation from his profile.
    """
    stiff = YOUNG / (1.0 - 0.3**2)
    force = load * stiff * R
    g = force / (pi * R * R)
    rate = C / R
    centre = R + 4.0 + np.array(at)
    floor = centre[1] - R - 1e-3
    bodies = {
        "disk": exact(ball(centre, R)),
        "floor": {"rigid": {}, "region": box([1.3, floor - 3.0], [2.0 * R + 7.7, floor])},
    }
    sim = pressed(bodies, [2.0 * R + 9.0, 2.0 * R + 8.0], 2, rate, g, waves / rate)
    middle, area, pushed, smoothed = pressures(sim)
    half = sqrt(4.0 * force * R / pi / stiff)
    top = 2.0 * force / pi / half
    x, found = middle[:, 0] - centre[0], pushed / area
    t = (np.arange(101) + 0.5) / 101.0 - 0.5
    hertz = top * np.array([
        np.sqrt(np.maximum(0.0, 1.0 - ((c + w * t) / half) ** 2)).mean()
        for c, w in zip(x, area, strict=True)
    ])  # fmt: skip
    on = found > 0.0
    return {
        "half width": half,
        "force": pushed.sum() / force,
        "greatest": found.max(initial=0.0) / top,
        "recovered": (smoothed / area).max(initial=0.0) / top,
        "rms": sqrt(((found - hertz)[on] ** 2).mean()) / top if on.any() else np.nan,
    }


def sphere(R=12.0, half=2.5, waves=40.0):
    """As `line`, of a quarter of a ball between two planes of symmetry."""
    stiff, rate = YOUNG / (1.0 - 0.3**2), C / R
    force = 4.0 * stiff * half**3 / (3.0 * R)
    high = R + 4.21
    within = box([0.0, 0.0, 0.0], [R + 4.0] * 2 + [2.0 * R + 8.0])
    bodies = {
        "ball": exact({"intersection": [ball([0.0, 0.0, high], R), within]}),
        "floor": {"rigid": {}, "region": box([-9.0, -9.0, 1.0], [R, R, high - R - 1e-3])},
    }
    sim = pressed(bodies, [R + 4.0, R + 4.0, 2.0 * R + 8.0], 3, rate,
                  force / (4.0 / 3.0 * pi * R**3), waves / rate,
                  boundaries={"x-min": "slip", "y-min": "slip"})  # fmt: skip
    _, area, pushed, smoothed = pressures(sim)
    top = 1.5 * force / (pi * half * half)
    return {
        "half width": half,
        "force": 4.0 * pushed.sum() / force,
        "greatest": (pushed / area).max(initial=0.0) / top,
        "recovered": (smoothed / area).max(initial=0.0) / top,
    }
