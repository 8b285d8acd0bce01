"""Dry sand that collapses, slides and leans on a wall: see `problems`."""

import meshio
import numpy as np
from studies.flow.problems import G, done
from studies.harness import out
from studies.scenes import ball, box, case_of, filled, looked, reading

#: Sand that shears at tan = 0.6, its repose of 31 degrees: phi is the arc sine.
LOOSE = {
    "model": "drucker-prager", "match": "plane-strain-flow", "poisson": 0.3, "density": 1500.0,
    "cohesion": 0.0, "friction-angle": 36.87,
}  # fmt: skip
#: A floor on which sand slides by its own friction.
ROUGH = {"unilateral": {"friction": 0.6}}


def heap(cell, ratio, volumetric="pointwise", shape="gimp", floor=None):
    """Run-out of a column of sand over its width, J that particles track, and filling inside.

    The front is where sand is a twentieth of the width deep, over a tenth of it: a thinner tongue
    runs ahead. Filling is mass in a box within what has run out, over density and area.
    """
    law = LOOSE | {"young": 1.0e6 * ratio}
    column = {"material": "sand"} | filled([0.0, 0.0], [1.0, ratio])
    sim, speed = done(case_of(
        [2.2 + 1.6 * ratio, ratio + 0.2], cell, {"sand": law}, {"column": column},
        6.0 * np.sqrt(ratio / G), method={"shape": shape, "volumetric": volumetric},
        gravity=[0.0, -G], boundaries={"x-min": "slip", "x-max": "slip", "y-min": floor or ROUGH},
    ))  # fmt: skip
    x, y = sim.particles["position"][:, :2].T
    area, half = cell**2 / 4.0, 0.25 * cell
    places = np.arange(0.05, x.max() + 0.1, 0.005)
    low, high = places[:, None] - 0.05, places[:, None] + 0.05
    covered = np.clip(np.minimum(high, x + half) - np.maximum(low, x - half), 0.0, None)
    depth = covered.sum(axis=1) * area / (2.0 * half * 0.1)
    front = float(places[np.argmax(depth < 0.05)])
    ran = (x > 1.0) & (x < 1.0 + 0.4 * ratio) & (y < 0.2)
    inside = float(area * np.count_nonzero(ran) / (0.08 * ratio))
    return (front - 1.0, float(sim.particles["volume-ratio"].mean()), inside), speed


def brake(cell, shape, floor=None):
    """Deceleration over g of the middle of a layer of sand, 1 m deep, on a floor."""
    layer = {"material": "sand", "velocity": [6.0, 0.0]} | filled([2.0, 0.0], [14.0, 1.0])
    case = case_of(
        [22.0, 1.6], cell, {"sand": LOOSE | {"young": 1.0e7}}, {"layer": layer}, 0.6,
        method={"shape": shape}, gravity=[0.0, -G], boundaries={"y-min": floor or ROUGH},
    )  # fmt: skip

    def look(sim):
        return sim.particles["position"][:, 0], sim.particles["velocity"][:, 0]

    ((start, _), (_, fast), (_, slow)), speed, _ = looked(case, (0.0, 0.1, 0.6), look)
    middle = np.abs(start - 8.0) < 1.5
    return (float(fast[middle].mean() - slow[middle].mean()) / (0.5 * G),), speed


def rest(cell, relaxation):
    """Kinetic energy of a column of sand that has collapsed, at 2 s over the greatest one.

    And how far from the middle its sand lies in the mean.
    """
    most = [0.0]
    changes = {
        "grid.cell": [cell, cell], "time.end": 2.0, "method.pic-damping": relaxation,
        "output.every": None,
    }  # fmt: skip
    sim, speed = done(
        "sand-column", lambda sim: most.append(sim.diagnostics()["kinetic-energy"]), **changes
    )
    part = sim.diagnostics()["kinetic-energy"] / max(most)
    return (part, float(np.abs(sim.particles["position"][:, 0]).mean())), speed


def slide(cell, material, surface):
    """Greatest part of a ball's particles deeper than a quarter of a cell in a slope, in 2.5 s.

    A ball of 5 m on a slope of 33 degrees in 3D: a plane, or a terrain of triangles with bumps of
    1 m. Sand slides with friction 0.3, water without.
    """
    low = np.tan(np.radians(33.0))
    normal = [np.sin(np.radians(33.0)), np.cos(np.radians(33.0)), 0.0]
    centre = [10.0 + 5.02 * normal[0], 34.0 - 2.0 * low + 5.02 * normal[1], 12.0]
    region = {"intersection": [
        {"half-space": {"point": [8.0, 34.0, 12.0], "normal": normal}},
        box([-5.0, -40.0, -5.0], [70.0, 60.0, 30.0]),
    ]}  # fmt: skip
    if surface == "terrain":
        file = out("flows") / "terrain.stl"
        _write_terrain(file, low)
        region, centre[1] = {"mesh": {"file": str(file)}}, centre[1] + 1.0
    laws = {
        "sand": {"model": "drucker-prager", "young": 1.0e7, "poisson": 0.3, "density": 1600.0,
                 "friction-angle": 25.0, "cohesion": 0.0},
        "water": {"model": "newtonian", "density": 1000.0, "bulk": 4.0e7, "shear-viscosity": 0.001},
    }  # fmt: skip
    faces = [f"{axis}-{end}" for axis in "xyz" for end in ("min", "max")]
    bodies = {
        "ball": {"material": "one", "region": ball(centre, 5.0)},
        "slope": {"rigid": {}, "region": region},
    }
    friction = 0.3 if material == "sand" else 0.0
    case = case_of(
        [64.0, 44.0, 24.0], cell, {"one": laws[material]}, bodies, 2.5, courant=0.4,
        gravity=[0.0, -G, 0.0], boundaries=dict.fromkeys(faces, "slip"),
        contact=[{"bodies": ["ball", "slope"], "friction": friction}],
    )  # fmt: skip
    inside = [0]
    sim, speed = done(
        case,
        lambda sim: inside.append(sim.diagnostics()["rigid.slope.penetrating-particles"]) or False,
    )
    return (float(max(inside)) / len(sim.particles["id"]),), speed


def _write_terrain(path, low):
    """Write a closed surface of triangles: a slope with bumps, down to 30 m below zero."""
    x, z = np.meshgrid(np.linspace(-4.0, 68.0, 49), np.linspace(-4.0, 28.0, 25), indexing="ij")
    y = 33.0 - (x - 8.0) * low + np.sin(x / 3.0) * np.cos(z / 4.0)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    top = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, d, c), (a, c, b))])
    edges = (number[:, 0], number[-1], number[::-1, -1], number[0, ::-1])
    walls = []
    for edge in edges:
        p, q = edge[:-1], edge[1:]
        walls += [np.stack((p, q, q + x.size), -1), np.stack((p, q + x.size, p + x.size), -1)]
    below = top[:, ::-1] + x.size
    points = np.stack([np.append(x, x), np.append(y, 0.0 * y - 30.0), np.append(z, z)], -1)
    meshio.write_points_cells(
        path, points.reshape(-1, 3), [("triangle", np.concatenate([top, below, *walls]))]
    )


def retained(cell, volumetric):
    """K_a of sand of 33 degrees on a rough base, and how its pressure differs within cells.

    The smooth wall recedes by 3 mm in 1 m; the difference is the root mean square, over the
    pressure of the height, of particles within 0.6 m of the wall.
    """
    law = {
        "model": "mohr-coulomb", "young": 1.0e4, "poisson": 0.3, "density": 1.0,
        "cohesion": 0.0, "friction-angle": 33.0,
    }  # fmt: skip
    recedes = {"table": [[0.0, 0.0], [0.5, 0.0], [0.6, -0.002]]}
    case = case_of(
        [2.0, 1.2], cell, {"sand": law},
        {"fill": {"material": "sand"} | filled([0.0, 0.0], [2.0, 1.0])}, 2.0,
        method={"volumetric": volumetric},
        gravity={"table": [[0.0, [0.0, 0.0]], [0.5, [0.0, -1.0]]]},
        boundaries={"x-min": {"velocity": [recedes, None]}, "x-max": "slip", "y-min": "fixed"},
    )  # fmt: skip
    thrusts, speed, sim = looked(case, np.linspace(1.5, 2.0, 21), reading("reaction.x-min-x"))
    places, p = sim.particles["position"][:, :2], -sim.particles["stress"][:, :3].mean(axis=1)
    _, of, count = np.unique(places // cell, axis=0, return_inverse=True, return_counts=True)
    of = of.ravel()
    off = (p - (np.bincount(of, p) / count)[of])[places[:, 0] < 0.6]
    return (float(np.mean(thrusts)) / 0.5, float(np.sqrt(np.mean(off**2)))), speed
