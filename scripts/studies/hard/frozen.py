"""Stress that stays frozen in particles: the part of it that no vertex feels, after impacts.

Run as ``scripts/hard frozen``: writes the table of docs/hard-cases.md,
scripts/pages/tables/frozen.md. Weights that change under stress put it into patterns that exert no
force. How much energy these hold is found apart from pgimp's steps: strains e_p are projected, in
the energy's own norm, on those that velocities of the grid can make, sym(sum_v u_v grad S_vp); the
locked-in energy is that of what is left.
"""

from math import sqrt

import numpy as np
from studies.harness import Table, put
from studies.scenes import ball, box, by_id, core, finished

from pgimp.errors import RunError
from pgimp.kernels.transfer.first_vertex import first_vertex

#: A ball that flies at a plate which yields by some cells.
STEEL = {
    "grid": {"origin": [-0.08, -0.03], "size": [0.16, 0.1], "cell": [0.00125] * 2},
    "time": {"end": 1.5e-3},
    "materials": {
        "steel": {"model": "neo-hookean", "young": 2.1e11, "poisson": 0.3, "density": 7850.0},
        "aluminium": {"model": "neo-hookean", "young": 7e10, "poisson": 0.33, "density": 2700.0},
    },
    "bodies": {
        "body": {"material": "steel", "region": ball([0.0, 0.028], 0.015), "velocity": [0, -20.0]},
        "plate": {"material": "aluminium", "region": box([-0.06, 0.0], [0.06, 0.01])},
        "left": {"material": "steel", "region": box([-0.06, -0.01], [-0.05, 0.0])},
        "right": {"material": "steel", "region": box([0.05, -0.01], [0.06, 0.0])},
    },
    "constraints": {
        name: {"body": name, "region": box(low, high), "velocity": [0.0, 0.0]}
        for name, low, high in (
            ("left", [-0.07, -0.02], [-0.04, -0.005]), ("right", [0.04, -0.02], [0.07, -0.005])
        )
    },
}  # fmt: skip


def rubber(end, region, velocity, **more):
    """A body above a wall that lets go."""
    entry = {"model": "neo-hookean", "young": 1e6, "poisson": 0.3, "density": 1000.0}
    return {
        "grid": {"origin": [-0.8, 0.0], "size": [3.6, 1.6], "cell": [0.0125] * 2},
        "time": {"end": end}, "materials": {"rubber": entry},
        "bodies": {"body": {"material": "rubber", "region": region, "velocity": velocity}},
        "boundaries": {"y-min": "unilateral"}, **more,
    }  # fmt: skip


ABOVE = ball([0.003, 0.17], 0.15)
SCENES = {
    "steel ball on a plate": STEEL | {"contact": [{"bodies": "all"}]}, "the same, sticking": STEEL,
    "rubber ball, 3 m/s": rubber(0.15, ABOVE, [0.0, -3.0]),
    "rubber ball, 8 m/s": rubber(0.15, ABOVE, [1.0, -8.0]),
    "sliding block": rubber(2.0, box([0.0, 0.0], [0.3, 0.15]), [1.0, 0.0], gravity=[0.0, -200.0]),
}  # fmt: skip
METHODS = [
    *((shape, affine, 2, "current") for shape in (
        "gimp", "finite-gimp", "cpdi", "bspline-quadratic", "fuzzy-constant"
    ) for affine in (False, True)),
    ("gimp", True, 1, "current"),
    ("gimp", False, 2, "initial"),
]  # fmt: skip


def strains(F):
    """Logarithmic strains of deformation gradients (n, 2, 2): xx, yy and sqrt(2) xy; (n, 3)."""
    squares, axes = np.linalg.eigh(F @ F.transpose(0, 2, 1))
    e = np.einsum("nij,nj,nkj->nik", axes, 0.5 * np.log(squares), axes)
    return np.stack([e[:, 0, 0], e[:, 1, 1], sqrt(2.0) * e[:, 0, 1]], axis=1)


def gradients(case, scene, x, F):
    """What a velocity (u, v) of a vertex gives to strains.

    The vertices (n, k) of each particle, and the gradients of their S_vp, (n, k, 2).
    """
    shape, cell = case.method.parameters(case.grid.cell), np.array(case.grid.cell)
    half = np.broadcast_to(np.array(shape.half), (len(x), 2))
    if scene.settings.follows:
        half = np.minimum(np.sqrt(((F * (half[0] * cell)) ** 2).sum(axis=2)) / cell, 1.0)
    n, frame = shape.vertices(), scene.domain.frame
    local = np.array([*np.ndindex(n, n)])
    first, w, g = np.empty((len(x), 2), int), *np.empty((2, len(x), 2, n))
    for i, d in np.ndindex(len(x), 2):
        first[i, d] = first_vertex(frame, d, half[i, d], x[i, d])
        f = (x[i, d] - frame.origin[d]) / cell[d] - (first[i, d] - frame.ghost)
        w[i, d], g[i, d] = type(shape).weights(shape, half[i, d], f)
    one, two = local.T
    slopes = [g[:, 0, one] * w[:, 1, two] / cell[0], w[:, 0, one] * g[:, 1, two] / cell[1]]
    at = first[:, None] + local[None]
    at -= at.min(axis=(0, 1))
    return at[..., 0] * (at[..., 1].max() + 1) + at[..., 1], np.stack(slopes, axis=-1)


def left_over(e, vertices, slopes, root, sweeps=2000):
    """Least squares: what is left of root e when that of sym(grad u) is taken off, (n, 3).

    By conjugate gradients on the normal equations; `root` (n, 3, 3) is the root of the stiffness.
    """
    count = vertices.max() + 1
    x, y = slopes[..., 0], slopes[..., 1]

    def strain(u):
        u = u[vertices]
        parts = (x * u[..., 0], y * u[..., 1], (y * u[..., 0] + x * u[..., 1]) * sqrt(0.5))
        return np.einsum("nij,nj->ni", root, np.stack([p.sum(axis=1) for p in parts], axis=1))

    def force(s):
        s = np.einsum("nij,ni->nj", root, s)[:, None]
        shear = s[..., 2] * sqrt(0.5)
        parts = (x * s[..., 0] + y * shear, y * s[..., 1] + x * shear)
        at = vertices.ravel()
        return np.stack([np.bincount(at, p.ravel(), count) for p in parts], axis=1)

    rest = np.einsum("nij,nj->ni", root, e)
    pull = force(rest)
    way, size, first = pull, (pull**2).sum(), (pull**2).sum()
    for _ in range(sweeps):
        if size <= 1e-20 * first:
            break
        made = strain(way)
        rest = rest - (size / (made**2).sum()) * made
        pull = force(rest)
        size, before = (pull**2).sum(), size
        way = pull + (size / before) * way
    return rest


def frozen(scene, shape, affine, per_cell, configuration):
    """Frozen and all elastic energy of the body at the end, over its kinetic energy at first."""
    case = {"format": 1, "dimensions": 2, **scene}
    case["time"] = scene["time"] | {"step": {"courant": 0.35}}
    case["method"] = {"shape": shape, "affine": affine, "particles-per-cell": [per_cell] * 2}
    bodies = scene["bodies"].items()
    case["bodies"] = {name: body | {"formulation": configuration} for name, body in bodies}
    sim = core(case)
    case, p, live = sim.scene.case, sim.particles, sim.live()
    places = by_id(sim, p.x[live])
    rows = live[p.body[live] == 0]
    first = 0.5 * (p.m[rows] * (p.v[rows] ** 2).sum(axis=1)).sum()
    finished(sim)
    live = sim.live()
    rows = live[p.body[live] == 0]
    x, F = p.x[rows], p.F[rows].reshape(-1, 2, 2)
    if configuration == "initial":
        x = places[p.id[rows]]
    material = case.materials[case.bodies["body"].material]
    E, nu = material.young, material.poisson
    mu, lam = 0.5 * E / (1.0 + nu), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    stiffness = lam * np.outer([1, 1, 0], [1, 1, 0]) + 2.0 * mu * np.eye(3)
    volume = p.V0[rows] * np.linalg.det(F)
    root = np.sqrt(volume)[:, None, None] * np.linalg.cholesky(stiffness).T
    e = strains(F)
    rest = left_over(e, *gradients(case, sim.scene, x, F), root)
    elastic = np.einsum("nij,nj->ni", root, e)
    return 0.5 * (rest**2).sum() / first, 0.5 * (elastic**2).sum() / first


def main():
    table = Table("method", *SCENES)
    for method in METHODS:
        shape, affine, per_cell, configuration = method
        title = f"{shape}{', affine' * affine}, {per_cell} a cell"
        found = []
        for scene in SCENES.values():
            try:
                part, whole = frozen(scene, *method)
                found.append(f"{100.0 * part:.2g} of {100.0 * whole:.2g}")
            except RunError as fault:
                found.append("stopped")
                print(fault)
        table.add(title + ", initial" * (configuration != "current"), *found)
    put({"frozen": table.text()})
