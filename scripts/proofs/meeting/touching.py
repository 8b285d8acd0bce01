"""Random scenes whose bodies meet by their surfaces: of few kinds, so that little is compiled.

A kind is the dimension, the geometry, and which faces let go, mirror or join; what is in it is
drawn for each scene.
"""

import math

from proofs.meeting import pressed
from proofs.scenes.bodies import number

SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
#: Of the soft solid, and of what is four times as stiff.
SPEED = 10.0
FLOOR = {"y-min": {"unilateral": {"friction": 0.2}}}
#: What flows, where some bodies are in the current configuration.
LOOSE = {
    "water": {"model": "newtonian", "bulk": 100.0, "density": 1.0, "shear-viscosity": 1e-3},
    "sand": SOFT | {
        "model": "drucker-prager", "cohesion": 0.0, "friction-angle": 30.0, "dilation-angle": 0.0,
    },
}  # fmt: skip
#: Boundaries of each kind of bodies that fly, and what its case has besides.
FLY = {
    "free": ({}, {}),
    "floor": (FLOOR, {}),
    "rings": (FLOOR, {"geometry": "axisymmetric"}),
    "seam": (FLOOR | {"x-min": "periodic", "x-max": "periodic"}, {}),
    "round": (dict.fromkeys(("x-min", "x-max", "y-min", "y-max"), "periodic"), {}),
    "mirror": (FLOOR | {"x-min": "slip"}, {}),
    "mixed": (FLOOR, {"mixed": True}),
    "mixed rings": (FLOOR, {"mixed": True, "geometry": "axisymmetric"}),
    "mixed seam": (FLOOR | {"x-min": "periodic", "x-max": "periodic"}, {"mixed": True}),
    "space": ({"z-min": "unilateral"}, {"dimensions": 3}),
    "space seam": (
        {"z-min": "unilateral", "y-min": "periodic", "y-max": "periodic"}, {"dimensions": 3},
    ),
}  # fmt: skip
KINDS = (*FLY, *pressed.KINDS)


def make(rng, kind):
    """A case of a kind."""
    materials = {"soft": SOFT, "stiff": SOFT | {"young": 400.0, "density": 4.0}}
    if kind in pressed.KINDS:
        return pressed.make(rng, kind, materials)
    boundaries, more = FLY[kind]
    D = more.get("dimensions", 2)
    cells = [rng.randint(13, 20), rng.randint(10, 14)] if D == 2 else [rng.randint(11, 14), 7, 7]
    sides = [1.0] * D if rng.random() < 0.5 else [number(rng, 0.8, 1.25) for _ in range(D)]
    size = [round(n * h, 6) for n, h in zip(cells, sides, strict=True)]
    rings = "geometry" in more
    origin = [0.0] * D
    if rings and rng.random() < 0.4:
        origin[0] = number(rng, 1.0, 9.0)
    elif not rings and rng.random() < 0.5:
        origin = [number(rng, -5.0, 5.0) for _ in range(D)]
    bodies = _bodies(rng, D, origin, size, boundaries, rings)
    soft = [name for name, body in bodies.items() if "rigid" not in body]
    if more.get("mixed"):
        for name in soft[1 : 1 + max(1, len(soft) // 2)]:
            del bodies[name]["formulation"]
            if not rings and rng.random() < 0.4:
                bodies[name]["material"] = rng.choice([*LOOSE])
    fast = 0.08 * rng.choice((1.0, 2.0, 4.0)) * SPEED
    middle = [a + 0.5 * s for a, s in zip(origin, size, strict=True)]
    for name, body in bodies.items():
        if body.get("rigid") == {}:
            _move_rigid(rng, body, D, 0.6 * fast, rings)
        else:
            body["velocity"] = _towards(rng, body.pop("at"), middle, fast, rings)
            turns = D == 2 and not rings and "periodic" not in boundaries.values()
            if turns and rng.random() < 0.3:
                turn = {"about": middle, "rate": number(rng, -0.2, 0.2) * fast}
                body["velocity"] = {"rotation": turn, "translation": body["velocity"]}
        body.pop("at", None)
    step = {"courant": number(rng, 0.15, 0.35)}
    end = number(rng, 0.5, 1.2) * min(size) / SPEED
    case = {
        "format": 1, "dimensions": D, "grid": {"origin": origin, "size": size, "cell": sides},
        "method": {"shape": "gimp", "particles-per-cell": [rng.choice((2, 2, 3)) for _ in sides]},
        "time": {"end": end, "step": step},
        "materials": materials,
        "bodies": bodies, "boundaries": boundaries, "contact": _laws(rng, bodies, more),
        "output": {"every": number(rng, 0.2, 0.6) * end, "fields": ["velocity", "stress"]},
        "history": {"every": {"steps": rng.randint(1, 9)}},
        "checkpoint": {"every": {"steps": rng.randint(3, 15)}, "keep": 4},
    }  # fmt: skip
    names = ["contact-pressure", "traction", "gap", "slip", "wear-work"]
    case["output"]["surface"] = rng.sample(names, rng.randint(1, 5))
    if more.get("mixed") and not rings:
        case["materials"] |= LOOSE
    if rings:
        case["geometry"] = "axisymmetric"
    if rng.random() < 0.4 and kind not in ("free", "round"):
        case["gravity"] = [0.0] * (D - 1) + [-number(rng, 0.5, 3.0)]
    if rng.random() < 0.25:
        case["output"]["every"] = {"steps": rng.randint(2, 9)}
    if rng.random() < 0.25:
        _stage(rng, case, soft, end)
    return case


def _bodies(rng, D, origin, size, boundaries, rings):
    """Two to four bodies that do not overlap, by balls around them; some rigid."""
    found, taken, count = {}, [], rng.choice((2, 3, 3, 4)) if D == 2 else 2
    joined = [f"{'xyz'[d]}-min" in boundaries and boundaries[f"{'xyz'[d]}-min"] == "periodic"
              for d in range(D)]  # fmt: skip
    halved = boundaries.get("x-min") == "slip" or (rings and origin[0] == 0.0)
    for _ in range(300):
        if len(found) == count:
            break
        radius = number(rng, 1.4, 2.6) if D == 2 else number(rng, 1.3, 1.7)
        at = []
        for d in range(D):
            margin = 0.0 if joined[d] and d == 0 else radius + 0.05
            ends = origin[d] + margin, origin[d] + size[d] - margin
            if taken:  # within reach of one that is there
                other, its = taken[-1]
                far = 0.75 * (radius + its) + 0.6
                ends = max(ends[0], other[d] - far), min(ends[1], other[d] + far)
            at.append(number(rng, *ends))
        cut = halved and rng.random() < 0.5
        if cut:
            at[0] = origin[0]
        elif halved and at[0] < origin[0] + radius:
            continue
        if any(_apart(at, other, size, joined) < radius + its for other, its in taken):
            continue
        taken.append((at, radius))
        rigid = len(found) >= 1 and rng.random() < 0.3
        state = rng.getstate()
        region = _region(rng, at, radius, D, cut, origin)
        if joined[0]:  # what reaches over the seam comes in on the other side
            after, images = rng.getstate(), [region]
            for way in (-size[0], size[0]):
                rng.setstate(state)
                shifted = [round(at[0] + way, 6), *at[1:]]
                images.append(_region(rng, shifted, radius, D, cut, origin))
            rng.setstate(after)
            if not origin[0] + radius < at[0] < origin[0] + size[0] - radius:
                corner = [round(a + b, 6) for a, b in zip(origin, size, strict=True)]
                inside = {"box": {"min": origin, "max": corner}}
                region = {"intersection": [{"union": images}, inside]}
        body = {"region": region, "at": at}
        if rigid and not cut:
            free = rng.random() < 0.6
            body["rigid"] = {"density": number(rng, 0.5, 5.0)} if free else {}
        else:
            body |= {"material": rng.choice(("soft", "stiff")), "formulation": "total-lagrangian"}
        found["abcdefgh"[len(found)]] = body
    if all("rigid" in body for body in found.values()) or len(found) < 2:
        return _bodies(rng, D, origin, size, boundaries, rings)
    return found


def _apart(one, other, size, joined):
    """Distance of the nearest images of two places."""
    ways = []
    for a, b, length, round_it in zip(one, other, size, joined, strict=True):
        way = abs(a - b)
        ways.append(min(way, length - way) if round_it else way)
    return math.hypot(*ways)


def _region(rng, at, radius, D, cut, origin):
    """What fills some of a ball."""
    half = [round(radius * number(rng, 0.6, 0.99) / math.sqrt(D), 4) for _ in range(D)]
    low, high = ([round(x + s * h, 4) for x, h in zip(at, half, strict=True)] for s in (-1, 1))
    box = {"box": {"min": low, "max": high}}
    ball = {"ball": {"centre": at, "radius": round(0.99 * radius, 4)}}
    kind = rng.random()
    if kind < 0.35:
        found = ball
    elif kind < 0.65:
        found = box
    elif kind < 0.8 and D == 2:  # a corner that points anywhere
        angle, sides = rng.uniform(0.0, math.tau), [ball]
        for turn in (0.0, 1.9, 4.1):
            normal = [round(math.cos(angle + turn), 4), round(math.sin(angle + turn), 4)]
            point = [x + 0.3 * radius * n for x, n in zip(at, normal, strict=True)]
            sides.append({"half-space": {"point": point, "normal": normal}})
        found = {"intersection": sides}
    elif kind < 0.9:
        hole = {"ball": {"centre": [x + 0.4 * radius for x in at], "radius": 0.6 * radius}}
        found = {"difference": [ball, hole]}
    else:
        found = {"union": [box, {"ball": {"centre": at, "radius": round(0.8 * min(half), 4)}}]}
    if cut:  # a half, at a plane of symmetry
        inside = {"half-space": {"point": origin, "normal": [-1.0] + [0.0] * (D - 1)}}
        found = {"intersection": [found, inside]}
    return found


def _towards(rng, at, middle, fast, rings):
    """A velocity that is more or less towards the middle."""
    way = [m - x + number(rng, -1.0, 1.0) for m, x in zip(middle, at, strict=True)]
    length = math.hypot(*way) or 1.0
    found = [float(f"{fast * w / length:.3g}") for w in way]
    return [0.0, *found[1:]] if rings else found


def _move_rigid(rng, body, D, fast, rings):
    """Let a rigid body stand, move or turn."""
    at, kind = body["at"], rng.random()
    velocity = [number(rng, -fast, fast) for _ in range(D)]
    if rings:
        velocity[0] = 0.0
    if kind < 0.6:
        body["rigid"] = {"velocity": velocity}
    elif kind < 0.8 and D == 2 and not rings:
        body["rigid"] = {"rotation": {"about": at, "rate": number(rng, -fast, fast) / 2.0}}


def _laws(rng, bodies, more):
    """A law for all pairs, and perhaps others for some."""
    friction = rng.choice((0.0, 0.2, 0.6, {"static": 0.5, "kinetic": 0.3}))
    law = {"bodies": "all", "friction": friction}
    rigid = [name for name, body in bodies.items() if "rigid" in body]
    soft = [name for name in bodies if name not in rigid]
    laws = [law]
    if rng.random() < 0.3:
        law["self"] = True
    if len(rigid) > 1 and rng.random() < 0.7 and "mixed" not in more:
        laws.append({"bodies": rigid, "restitution": number(rng, 0.0, 1.0), "friction": 0.1})
    if len(soft) > 1 and rng.random() < 0.2:
        ways = {"law": "ignore"}, {"friction": 0.9}, {"law": "tie"}
        laws.append({"bodies": soft[:2], **rng.choice(ways[: 2 if "mixed" in more else 3])})
    return laws


def _stage(rng, case, soft, end):
    """A second part of the run: another friction, or without a body."""
    cut = number(rng, 0.3, 0.7) * end
    case["time"]["end"] = cut
    stage = {"name": "later", "end": end}
    names = [*case["bodies"]]
    if len(soft) > 1 and len(names) > 2 and rng.random() < 0.5:
        gone = soft[-1]
        stage["remove"] = [gone]
        if any(gone in law["bodies"] for law in case["contact"] if law["bodies"] != "all"):
            stage["contact"] = [law for law in case["contact"] if law["bodies"] == "all"]
    else:
        stage["contact"] = [{"bodies": "all", "friction": number(rng, 0.0, 0.8)}]
    case["time"]["stages"] = [stage]
