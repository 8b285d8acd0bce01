"""Random drums and heaps of many bodies that touch, three and more at a vertex."""

from math import hypot

SOFT = {"model": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1.0}
SAND = {
    "model": "drucker-prager", "young": 1000.0, "poisson": 0.3, "density": 1.0, "cohesion": 0.0,
    "friction-angle": 30.0,
}  # fmt: skip
#: As pgimp calms each of so many bodies of loose soil, but not more.
CALMED = 16


def drum(rng):
    """Grains in a drum that turns."""
    case = _heap(rng, 2, rng.randint(40, 100), round)
    wide, high = case["grid"]["size"]
    centre = [0.5 * wide, 0.5 * high]
    radius = 0.5 * hypot(wide, high)
    hole = {"ball": {"centre": centre, "radius": radius}}
    size = 2.0 * radius + 4.0
    case["grid"] = {"origin": [x - 0.5 * size for x in centre], "size": [size] * 2}
    around = {"box": {"min": [x - size for x in centre], "max": [x + size for x in centre]}}
    turns = {"about": centre, "rate": rng.choice((-1.0, 1.0)) * 3.0 / radius}
    rigid = {"rigid": {"rotation": turns}, "region": {"difference": [around, hole]}}
    case["bodies"] = {"drum": rigid} | case["bodies"]
    case["boundaries"] = {}
    return case


def heap(rng):
    """Grains that fall into a box, with a wall that pushes."""
    case = _heap(rng, 2, rng.randint(40, 100), rng.choice((round, square)))
    if rng.random() < 0.3:
        case["boundaries"]["x-max"] = {"velocity": [-0.5, None]}
    return case


def stone(rng):
    """Grains in a box, into which a stone falls that moves freely."""
    case = _heap(rng, 2, rng.randint(20, 50), rng.choice((round, square)))
    wide, high = case["grid"]["size"]
    place = [rng.uniform(0.3, 0.7) * wide, high + 1.0]
    case["grid"]["size"] = [wide, high + 8.0]
    case["bodies"]["stone"] = {
        "rigid": {"density": rng.uniform(1.0, 4.0)}, "velocity": [rng.uniform(-1.0, 1.0), -3.0],
        "region": {"ball": {"centre": place, "radius": 2.2}},
    }  # fmt: skip
    return case


def sand(rng):
    """Blocks of loose soil, few enough to be calmed or too many, between elastic ones."""
    soil = rng.choice((CALMED, CALMED // 2, CALMED + 4))
    case = _heap(rng, 2, rng.randint(24, 40), square)
    case["materials"]["sand"] = SAND
    names = [*case["bodies"]]
    for name in rng.sample(names, soil):
        case["bodies"][name]["material"] = "sand"
    case["method"]["pic-damping"] = "auto"
    return case


def balls(rng):
    """A heap of balls."""
    return _heap(rng, 3, rng.randint(20, 30), round)


def initial(rng):
    """Grains in the initial configuration."""
    return _heap(rng, 2, rng.randint(20, 30), round, lagrangian=1.0)


def mixed(rng):
    """Grains in either configuration."""
    return _heap(rng, 2, rng.randint(20, 24), round, lagrangian=0.5)


def round(centre, radius):
    """A disk, or a ball."""
    return {"ball": {"centre": centre, "radius": radius}}


def square(centre, radius):
    """A box as wide."""
    low, high = ([x + sign * 0.9 * radius for x in centre] for sign in (-1.0, 1.0))
    return {"box": {"min": low, "max": high}}


KINDS = {
    each.__name__: each for each in (drum, heap, stone, sand, balls, initial, mixed)
}  # fmt: skip


def make(rng, kind):
    """A case of a kind; bodies do not stand in the order of their places."""
    case = KINDS[kind](rng)
    case["grid"]["cell"] = [1.0] * case["dimensions"]
    case["grid"]["size"] = [float(int(x + 0.999)) for x in case["grid"]["size"]]
    bodies = [*case["bodies"].items()]
    rng.shuffle(bodies)
    case["bodies"] = dict(bodies)
    return case


def _heap(rng, D, count, region, lagrangian=0.0):
    """Bodies `region` on a loose lattice above a floor, each with a velocity of its own."""
    most = 1.8 if D == 2 else 1.4
    pitch = 2.0 * most + 0.1
    across = max(2, int(count ** (1.0 / D) * (1.2 if D == 2 else 1.0)))
    bodies = {}
    for n in range(count):
        place, rest = [], n
        for _ in range(D - 1):
            place.append(rest % across)
            rest //= across
        place.append(rest)
        radius = rng.uniform(0.6, 1.0) * most
        slack = most - radius
        shift = 0.5 * (place[-1] % 2)
        centre = [pitch * (x + 0.5 + shift * (d < D - 1)) + rng.uniform(-slack, slack)
                  for d, x in enumerate(place)]  # fmt: skip
        body = {"material": "soft", "region": region(centre, radius), "surface": "whole-particles"}
        body["velocity"] = [rng.uniform(-1.5, 1.5) for _ in range(D)]
        body["velocity"][-1] = rng.uniform(-2.0, 0.0)
        if rng.random() < lagrangian:
            body["formulation"] = "total-lagrangian"
        bodies[f"g{n}"] = body
    size = [pitch * (across + 0.5)] * (D - 1) + [pitch * (-(-count // across ** (D - 1)) + 1)]
    wall = {"unilateral": {"friction": 0.3}}
    shape = "finite-gimp" if lagrangian else "gimp"
    friction = rng.choice((0.0, 0.3, {"static": 0.6, "kinetic": 0.4}))
    step = rng.choice((0.01, {"courant": 0.4}))
    return {
        "format": 1,
        "dimensions": D,
        "grid": {"origin": [0.0] * D, "size": size},
        "method": {
            "shape": shape, "particles-per-cell": [2] * D,
            "affine": not lagrangian and rng.random() < 0.7,
        },
        "time": {"end": 1.5 if D == 2 else 0.6, "step": step},
        "materials": {"soft": SOFT},
        "bodies": bodies,
        "gravity": [0.0] * (D - 1) + [-3.0],
        "boundaries": {f"{axis}-{end}": wall for axis in "xyz"[:D] for end in ("min", "max")},
        "contact": [{"bodies": "all", "friction": friction}],
        "output": {
            "every": {"steps": 17}, "fields": ["velocity", "stress"],
            "grid": ["mass", "contact"] if rng.random() < 0.5 and not lagrangian else ["mass"],
        },
        "history": {"every": {"steps": 1}},
        "checkpoint": {"every": {"steps": 13}, "keep": 100},
    }  # fmt: skip
