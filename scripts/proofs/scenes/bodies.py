"""Bodies of random scenes: where they lie, what they fill, how they move at the start.

A new kind of region is a function ``(rng, low, high, scene) -> region`` that fills some of the box
from `low` to `high`, and a line in `REGIONS`.
"""

import itertools
import math


def number(rng, low, high):
    """A number in a few digits, so that case files are easy to read."""
    return float(f"{rng.uniform(low, high):.3g}")


def vector(rng, dimension, most):
    """A vector with components up to `most`; now and then some are zero."""
    return [number(rng, -most, most) if rng.random() < 0.8 else 0.0 for _ in range(dimension)]


def middle(low, high):
    return [0.5 * (a + b) for a, b in zip(low, high, strict=True)]


def radius(low, high):
    """Of the largest ball in a box, a little less so that rounding does not matter."""
    return float(f"{0.499 * min(b - a for a, b in zip(low, high, strict=True)):.4g}")


# -- regions


def box(rng, low, high, scene):
    return {"box": {"min": low, "max": high}}


def ball(rng, low, high, scene):
    return {"ball": {"centre": middle(low, high), "radius": radius(low, high)}}


def cylinder(rng, low, high, scene):
    """One that lies in any direction within the largest ball."""
    axis = [rng.gauss(0.0, 1.0) for _ in low]
    size, centre = math.hypot(*axis), middle(low, high)
    half = [0.7 * radius(low, high) * a / size for a in axis]
    ends = [[round(c + s * h, 4) for c, h in zip(centre, half, strict=True)] for s in (-1, 1)]
    return {"cylinder": {"from": ends[0], "to": ends[1], "radius": 0.7 * radius(low, high)}}


def union(rng, low, high, scene):
    """Two that overlap."""
    cut = middle(low, high)
    first = box(rng, low, [cut[0], *high[1:]], scene)
    return {"union": [first, (ball if rng.random() < 0.5 else box)(rng, low, high, scene)]}


def difference(rng, low, high, scene):
    """A box or a ball without a part of it."""
    whole = (ball if rng.random() < 0.3 else box)(rng, low, high, scene)
    hole = {"ball": {"centre": high, "radius": 0.9 * radius(low, high)}}
    return {"difference": [whole, hole]}


def intersection(rng, low, high, scene):
    """What a ball and a box that does not cover it share."""
    cut = [number(rng, a, 0.7 * a + 0.3 * b) for a, b in zip(low, high, strict=True)]
    return {"intersection": [ball(rng, low, high, scene), box(rng, cut, high, scene)]}


def half_space(rng, low, high, scene):
    """A box or a ball on one side of a plane of any direction."""
    whole = (ball if rng.random() < 0.4 else box)(rng, low, high, scene)
    point = [number(rng, 0.2 * a + 0.8 * b, b) for a, b in zip(low, high, strict=True)]
    normal = [number(rng, -0.3, 1.0) for _ in low[1:]] + [1.0]
    return {"intersection": [whole, {"half-space": {"point": point, "normal": normal}}]}


def mesh(rng, low, high, scene):
    """A double pyramid from a file; a square on its corner in 2D."""
    centre, half = middle(low, high), [0.499 * (b - a) for a, b in zip(low, high, strict=True)]
    name, corners = f"mesh{len(scene.files)}", []
    for d, side in itertools.product(range(len(low)), (-1.0, 1.0)):
        corners.append([c + side * half[d] * (d == i) for i, c in enumerate(centre)])
    if len(low) == 3:
        faces = itertools.product((1, 2), (3, 4), (5, 6))
        # Outwards: as many odd corners as make the triple product positive.
        turned = [f if sum(n % 2 for n in f) % 2 == 0 else f[::-1] for f in faces]
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners]
        lines += [f"f {a} {b} {c}" for a, b, c in turned]
        scene.files[f"{name}.obj"] = "\n".join(lines) + "\n"
        return {"mesh": {"file": f"{name}.obj"}}
    nodes = [f"{n} {x!r} {y!r} 0.0" for n, (x, y) in enumerate(corners, 1)]
    cells = ["1 2 2 0 1 1 2 4", "2 2 2 0 1 2 1 3"]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "4", *nodes, "$EndNodes"]
    lines += ["$Elements", "2", *cells, "$EndElements"]
    scene.files[f"{name}.msh"] = "\n".join(lines) + "\n"
    return {"mesh": {"file": f"{name}.msh"}}


def heights(rng, low, high, scene):
    """Ground below a grid of heights from a file, of a part of it."""
    D, name = len(low), f"heights{len(scene.files)}.asc"
    counts = [rng.randint(3, 6) for _ in low[1:]] + [1] * (D == 2)
    ends = list(zip(low, high, strict=True))
    steps = [(b - a) / (n - 1) for (a, b), n in zip(ends[:-1], counts, strict=False)]
    floor, top = ends[-1]
    rows = [
        " ".join(repr(number(rng, 0.6 * floor + 0.4 * top, top)) for _ in range(counts[0]))
        for _ in range(counts[1])
    ]
    lines = [f"ncols {counts[0]}", f"nrows {counts[1]}"]
    for axis, (a, _), step in zip("xy", ends, [*steps, 1.0][:2], strict=False):
        lines += [f"{axis}llcenter {a!r}", f"d{axis} {step!r}"]
    scene.files[name] = "\n".join([*lines, *rows]) + "\n"
    region = {"file": name, "bottom": floor}
    if rng.random() < 0.5:
        inner = [(0.9 * a + 0.1 * b, 0.2 * a + 0.8 * b) for a, b in ends[:-1]]
        region["part"] = {"min": [a for a, _ in inner], "max": [b for _, b in inner]}
    return {"heights": region}


def points(rng, low, high, scene):
    """Particles from a file, in disorder, often with velocities, and stresses where they may."""
    D, apart = len(low), [h / n for h, n in zip(scene.cell, scene.per_cell, strict=True)]
    counts = [max(1, int((b - a) / s)) for a, b, s in zip(low, high, apart, strict=True)]
    moves, stressed = rng.random() < 0.6, scene.stressed and rng.random() < 0.5
    names = [*"xyz"[:D], "volume"] + [f"velocity-{a}" for a in "xyz"[:D]] * moves
    stresses = ("xx", "yy", "zz", "xy", "yz", "xz")[: 6 if D == 3 else 4] * stressed
    names += [f"stress-{c}" for c in stresses]
    rows = []
    for place in itertools.product(*map(range, counts)):
        jitter = [rng.uniform(0.3, 0.7) for _ in place]
        x = [a + s * (n + j) for a, s, n, j in zip(low, apart, place, jitter, strict=True)]
        row = [*x, math.prod(apart) * rng.uniform(0.8, 1.1)]
        row += [rng.uniform(-1.0, 1.0) for _ in range(D)] * moves
        row += [rng.uniform(-0.5, 0.5) for _ in stresses]
        rows.append(",".join(f"{value:.6g}" for value in row))
    rng.shuffle(rows)
    name = f"points{len(scene.files)}.csv"
    scene.files[name] = "\n".join([",".join(names), *rows]) + "\n"
    return {"points": {"file": name}}


#: What may fill a body, in how many dimensions, and how often.
REGIONS = {
    "box": (box, (1, 2, 3), 4),
    "ball": (ball, (1, 2, 3), 2),
    "cylinder": (cylinder, (3,), 2),
    "union": (union, (1, 2, 3), 1),
    "difference": (difference, (2, 3), 1),
    "intersection": (intersection, (1, 2, 3), 1),
    "half-space": (half_space, (1, 2, 3), 1),
    "mesh": (mesh, (2, 3), 1),
    "heights": (heights, (2, 3), 1),
    "points": (points, (1, 2, 3), 2),
}


# -- bodies


def place(rng, begin, end, cell, least, most):
    """An interval of `least` to `most` cells within another one: at an end of it, or anywhere."""
    length = min(number(rng, least, most) * cell, end - begin)
    where = rng.random()
    start = rng.uniform(begin, end - length)
    if where < 0.4:
        start = begin if where < 0.25 else end - length
    elif where < 0.7:  # where the lattice has a cell's edge or its middle
        length = max(cell, 0.5 * cell * round(2.0 * length / cell))
        start = min(begin + 0.5 * cell * round(2.0 * (start - begin) / cell), end - length)
    # Digits that no rounding can bring out of the domain.
    return max(begin, round(start, 6)), min(end, round(start + length, 6))


def add_bodies(rng, scene):
    """Up to three, each in a part of the domain along x of its own; each material has one."""
    case, D = scene.case, scene.dimension
    count = max(min(rng.choice((1, 2, 2, 3)), scene.cells[0] // 4), len(case["materials"]))
    low, size = case["grid"]["origin"], case["grid"]["size"]
    for i in range(count):
        begin, end = (low[0] + (i + e) * size[0] / count for e in (0, 1))
        slot = [place(rng, begin, end, scene.cell[0], 1.5, 4.5)]
        for d in range(1, D):
            slot.append(place(rng, low[d], low[d] + size[d], scene.cell[d], 1.2, 3.5))
        corners = [each[0] for each in slot], [each[1] for each in slot]
        kinds = {name: entry for name, entry in REGIONS.items() if D in entry[1]}
        kind = rng.choices([*kinds], [share for _, _, share in kinds.values()])[0]
        scene.stressed = case["materials"][scene.materials[i]]["model"] == "hooke"
        body = {"material": scene.materials[i], "region": kinds[kind][0](rng, *corners, scene)}
        if rng.random() < 0.3:
            body["surface"] = "whole-particles"
        body["velocity"] = motion(rng, scene, corners)
        case["bodies"][f"body{i}"] = body
        scene.corners[f"body{i}"] = corners


def thin(rng, scene):
    """Some boxes are one cell wide along a direction, with edges on lines of the grid."""
    low, found = scene.case["grid"]["origin"], False
    for name, body in scene.case["bodies"].items():
        if "box" not in body["region"] or rng.random() < 0.4:
            continue
        axis = rng.randrange(scene.dimension)
        cell, (start, end) = scene.cell[axis], (each[axis] for each in scene.corners[name])
        first = math.ceil((start - low[axis]) / cell - 1e-3)
        edges = [round(low[axis] + (first + n) * cell, 6) for n in (0, 1)]
        if edges[1] <= end + 1e-3 * cell:
            for corner, edge in zip(scene.corners[name], edges, strict=True):
                corner[axis] = edge  # those of the region, too
            found = True
    return found


def motion(rng, scene, corners):
    """A velocity, or a rotation about a point in the body or far off."""
    D, fast = scene.dimension, 0.2 * scene.speed
    velocity = vector(rng, D, fast)
    if D == 1 or rng.random() < 0.6:
        return velocity
    rate = fast / max(b - a for a, b in zip(*corners, strict=True))
    about = [number(rng, a, b) for a, b in zip(*corners, strict=True)]
    turn = number(rng, -rate, rate) if D == 2 else vector(rng, 3, rate)
    return {"rotation": {"about": about, "rate": turn}, "translation": velocity}


#: Materials whose density is inertia and nothing else.
INERTIA_ALONE = ("hooke", "neo-hookean", "linear-1d", "von-mises", "drucker-prager",
                 "mohr-coulomb", "cam-clay")  # fmt: skip


def mass_scaling(rng, scene):
    """Inertia is larger, where nothing begins to move by itself."""
    case, bodies = scene.case, scene.case["bodies"].values()
    of = [case["materials"][body["material"]] for body in bodies if "rigid" not in body]
    if (
        {"exact", "inflow", "body-force"} & {*case}
        or any("absorbing" in str(kind) for kind in case["boundaries"].values())
        or any("absorbing" in str(stage) for stage in case["time"].get("stages", ()))
        or any("density" in body.get("rigid", {}) for body in bodies)
        or not all(entry["model"] in INERTIA_ALONE for entry in of)
        or not all(isinstance(entry["density"], float) for entry in of)
    ):
        return False
    for body in bodies:
        body.pop("velocity", None)
    case["time"]["mass-scaling"] = number(rng, 1.0, 30.0)
    return True
