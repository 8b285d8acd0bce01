"""Features of random scenes that meet their bodies: rigid bodies, and laws of contact.

See `scene_features`.
"""

import math

from proofs.scenes.bodies import ball, box, middle, number, union, vector
from proofs.scenes.loads import table


def rigid_bodies(rng, scene):
    """One or two rigid bodies, beside a body, that stand, move or turn."""
    D, h = scene.dimension, scene.cell
    for number_of in range(rng.choice((1, 1, 2))):
        low, high = (list(corner) for corner in scene.corners[rng.choice([*scene.corners])])
        d, side = rng.randrange(D), rng.choice((-1, 1))
        size = [b - a + number(rng, 0.0, 2.0) * c for a, b, c in zip(low, high, h, strict=True)]
        size[d] = number(rng, 1.2, 3.0) * h[d]
        gap = number(rng, 0.0, 1.5) * h[d] if rng.random() < 0.7 else 0.0
        first = [a + number(rng, -1.0, 1.0) * c for a, c in zip(low, h, strict=True)]
        first[d] = high[d] + gap if side > 0 else low[d] - gap - size[d]
        last = [a + b for a, b in zip(first, size, strict=True)]
        kind = rng.random()
        made = box if kind < 0.5 else (ball if kind < 0.75 else union)
        motion, most = {}, 0.15 * scene.speed
        if rng.random() < 0.7:
            velocity = vector(rng, D, most)
            velocity[d] = -side * number(rng, 0.0, most)
            motion["velocity"] = velocity if rng.random() < 0.6 else table(rng, scene, most, D)
        if D > 1 and rng.random() < 0.4:
            rate = most / max(size)
            turns = number(rng, -rate, rate) if rng.random() < 0.6 else table(rng, scene, rate)
            motion["rotation"] = {"about": middle(first, last), "rate": turns}
            if D == 3:
                motion["rotation"]["axis"] = [1.0, *vector(rng, 2, 1.0)]
        region = made(rng, first, last, scene)
        scene.case["bodies"][f"tool{number_of}"] = {"rigid": motion, "region": region}


def free(rng, scene):
    """A rigid body that moves freely towards a body beside it: lighter, heavier, or alike."""
    D, h, grid = scene.dimension, scene.cell, scene.case["grid"]
    for _ in range(20):  # as walls are not felt, within the domain
        low, high = rng.choice([*scene.corners.values()])
        d, side = rng.randrange(D), rng.choice((-1, 1))
        size = [number(rng, 1.5, 4.0) * c for c in h]
        first = [number(rng, a - 0.5 * s, b - 0.5 * s)
                 for a, b, s in zip(low, high, size, strict=True)]  # fmt: skip
        gap = number(rng, 0.0, 1.0) * h[d]
        first[d] = high[d] + gap if side > 0 else low[d] - gap - size[d]
        last = [a + b for a, b in zip(first, size, strict=True)]
        corner = [a + b for a, b in zip(grid["origin"], grid["size"], strict=True)]
        if all(a >= b for a, b in zip([*first, *corner], [*grid["origin"], *last], strict=True)):
            break
    velocity = vector(rng, D, 0.1 * scene.speed)
    velocity[d] = -side * number(rng, 0.0, 0.15 * scene.speed)
    free = {"density": 10.0 ** number(rng, -3.0, 2.0)}
    if rng.random() < 0.3:
        free["fixed"] = [rng.choice(("rotation", "x") if D > 1 else ("x",))]
        velocity[0] *= free["fixed"] != ["x"]
    mass = free["density"] * math.prod(b - a for a, b in zip(first, last, strict=True))
    if rng.random() < 0.25:
        free["force"] = vector(rng, D, 0.05 * mass * scene.speed**2 / max(size))
    if rng.random() < 0.25:
        rate = number(rng, 0.05, 0.5) * scene.speed / max(size)
        free["spring"] = {"stiffness": mass * rate**2, "dashpot": 0.3 * mass * rate}
    entry = {"rigid": free, "region": rng.choice((box, ball, union))(rng, first, last, scene)}
    entry["velocity"] = velocity
    if D > 1 and not free.get("fixed") and rng.random() < 0.4:
        turns = vector(rng, 3, 0.1 * scene.speed / max(size))
        rotation = {"about": middle(first, last), "rate": turns if D == 3 else turns[2]}
        entry["velocity"] = {"rotation": rotation, "translation": velocity}
    scene.case["bodies"]["flies"] = entry


def contact(rng, scene):
    """A law for all pairs of bodies, or for some; with two bodies or more."""
    names = [*scene.case["bodies"]]
    if len(names) < 2:
        return

    def entry(bodies):
        law = rng.choice(("friction", "friction", "friction", "tie", "ignore"))
        found = {"bodies": bodies, "law": law}
        if law == "friction" and rng.random() < 0.7:
            most = number(rng, 0.0, 1.0)
            kinetic = number(rng, 0.0, 0.9) * most
            found["friction"] = most if rng.random() < 0.5 else {"static": most, "kinetic": kinetic}
        if law == "friction" and rng.random() < 0.25:
            strength = 10.0 ** number(rng, -2.0, 1.0)
            found["adhesion"] = {
                rng.choice(("normal", "shear")): strength,
                "reach": number(rng, 0.05, 0.9) * min(scene.case["grid"]["cell"]),
            }
            if rng.random() < 0.5:
                found["adhesion"] |= {"normal": strength, "shear": 0.5 * strength}
        return found

    entries = [entry("all")] if rng.random() < 0.7 else []
    if not entries or rng.random() < 0.4:
        entries.append(entry(rng.sample(names, rng.randint(2, len(names)))))
    scene.case["contact"] = entries
