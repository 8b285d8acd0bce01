"""Features of random scenes that move bodies from outside; see `scene_features`."""

import math

from proofs.scenes.bodies import number, vector
from proofs.scenes.materials import runs


def table(rng, scene, most, size=None):
    """A load or velocity over the time of the run, linear in between."""
    times = sorted({round(rng.uniform(-0.2, 1.2) * scene.end, 5) for _ in range(rng.randint(1, 4))})
    value = (lambda: number(rng, -most, most)) if size is None else lambda: vector(rng, size, most)
    return {"table": [[time, value()] for time in times]}


def over_time(rng, scene):
    """Ramps and sinusoids in place of some tables of numbers; gravity by components."""
    case = scene.case
    if isinstance(case.get("gravity"), dict):
        rows = case["gravity"]["table"]
        case["gravity"] = [
            {"table": [[time, row[d]] for time, row in rows]} for d in range(scene.dimension)
        ]
    for key in ("gravity", "boundaries", "constraints", "tractions", "bodies"):
        if key in case:
            case[key] = _smooth(rng, scene, case[key])


def _smooth(rng, scene, value):
    """A part of a case with ramps and sinusoids in place of some tables of numbers."""
    if isinstance(value, list):
        return [_smooth(rng, scene, each) for each in value]
    if not isinstance(value, dict):
        return value
    if "table" not in value:
        return {key: _smooth(rng, scene, each) for key, each in value.items()}
    (begin, first), (end, last) = value["table"][0], value["table"][-1]
    if isinstance(first, list) or rng.random() < 0.2:
        return value
    if rng.random() < 0.5:
        duration = max(end - begin, 0.1 * scene.end)
        return {"ramp": {"from": first, "to": last, "begin": begin, "duration": duration}}
    sine = {"amplitude": 0.5 * (last - first), "mean": 0.5 * (last + first), "begin": begin}
    sine |= {"frequency": number(rng, 0.5, 4.0) / scene.end, "phase": number(rng, -3.0, 3.0)}
    return {"sine": sine | ({"end": end} if end > begin and rng.random() < 0.5 else {})}


def components(rng, scene, most):
    """A prescribed velocity: by component a number, a table, or free; one is held at least."""
    found = []
    for _ in range(scene.dimension):
        kind = rng.random()
        found.append(number(rng, -most, most) if kind < 0.4 else 0.0)
        if kind > 0.5:
            found[-1] = table(rng, scene, most) if kind < 0.75 else None
    if all(each is None for each in found):
        found[0] = 0.0
    return found


def gravity(rng, scene):
    """Constant, or over time."""
    most = 0.05 * scene.speed**2 / max(scene.cells)
    value = vector(rng, scene.dimension, most)
    scene.case["gravity"] = value if rng.random() < 0.6 else table(
        rng, scene, most, scene.dimension
    )  # fmt: skip


def weight_above(rng, scene):
    """Bodies begin with the stress of the weight above, along one axis."""
    case, bodies = scene.case, scene.case["bodies"].values()
    if case.get("geometry") == "plane-stress" or any(
        "density" in body.get("rigid", {}) or body.get("formulation") or "points" in body["region"]
        for body in bodies
    ):
        return False
    axis = 1 if case.get("geometry") == "axisymmetric" else rng.randrange(scene.dimension)
    most = 0.05 * scene.speed**2 / max(scene.cells)
    pull = number(rng, 0.2 * most, most) * rng.choice((-1.0, 1.0))
    case["gravity"] = [pull if d == axis else 0.0 for d in range(scene.dimension)]
    solid = [name for name, body in case["bodies"].items() if "rigid" not in body]
    each = {name: number(rng, 0.3, 1.5) for name in solid}
    case["start"] = {"stress": {"k0": each if rng.random() < 0.5 else each[solid[0]]}}
    return True


def water(rng, scene):
    """Water in the pores of some bodies, with a level that may move; stages may change it."""
    case, stages = scene.case, scene.case["time"].get("stages", ())
    rings = case.get("geometry") == "axisymmetric"
    walls = case["boundaries"]
    free = [d for d in range(scene.dimension) if walls.get(f"{'xyz'[d]}-min") != "periodic"]
    weighs = "k0" in case.get("start", {}).get("stress", {})
    if weighs and "tractions" in case and rng.random() < 0.5:
        case["start"]["stress"]["surcharge"] = [*case["tractions"]]
    if weighs:
        steady = [d for d, part in enumerate(case["gravity"]) if isinstance(part, float) and part]
        free = [d for d in free if d in steady]
    elif rings:
        free = [d for d in free if d == 1]
    if "exact" in case or not free:
        return False
    axis, most = rng.choice(free), 0.05 * scene.speed**2 / max(scene.cells)
    if not weighs:
        case["gravity"] = [0.0 if rings else number(rng, 0.0, 0.4 * most) for _ in scene.cells]
        case["gravity"][axis] = number(rng, 0.5 * most, most) * rng.choice((-1.0, 1.0))
    for stage in stages:
        stage.pop("gravity", None)
    low, size = case["grid"]["origin"][axis], case["grid"]["size"][axis]
    up = -1.0 if case["gravity"][axis] > 0.0 else 1.0
    levels = [round(up * (low + rng.uniform(0.1, 0.9) * size), 4) for _ in range(2)]
    level = {"table": [[0.0, levels[0]], [round(0.7 * scene.end, 5), levels[1]]]}
    solid = {name: body for name, body in case["bodies"].items() if "rigid" not in body}
    each = [case["materials"][body["material"]]["density"] for body in solid.values()]
    density = number(rng, 0.1, 0.9) * min(one if isinstance(one, float) else 0.1 for one in each)
    case["water"] = {"level": level if rng.random() < 0.4 else levels[0], "density": density}
    if rng.random() < 0.3:
        case["water"]["bodies"] = [rng.choice([*solid])]
    for stage in stages:
        if rng.random() < 0.3:
            stage["water"] = {"level": levels[1], "density": density}
    return True


def damping(rng, scene):
    """Of one or two kinds; local damping knows no forces of contact, and a free body has none."""
    case, solid = scene.case, [b for b in scene.case["bodies"].values() if "rigid" not in b]
    if any("density" in body.get("rigid", {}) for body in case["bodies"].values()):
        return
    initial = {body.get("formulation") == "total-lagrangian" for body in solid}
    meets = case.get("contact") or len(solid) < len(case["bodies"]) or initial != {False}
    kinds = {"mass": number(rng, 0.1, 2.0) / scene.end, "kinetic": True}
    if not meets:
        kinds["local"] = number(rng, 0.05, 0.8)
    chosen = [kind for kind in kinds if rng.kind.random() < 0.5] or ["mass"]
    case["damping"] = {kind: kinds[kind] for kind in chosen}


def _on_surface(rng, scene, bodies):
    """A load on the surface of any body, from its corner to somewhere inside or beyond it."""
    name = rng.choice([name for name, body in bodies.items() if "points" not in body["region"]]
                      or [next(iter(bodies))])  # fmt: skip
    low, high = scene.corners[name]
    least = [a - (b - a) for a, b in zip(low, high, strict=True)]
    most = [a + number(rng, 0.6, 2.0) * (b - a) for a, b in zip(low, high, strict=True)]
    region = {"box": {"min": least, "max": most}}
    return {"body": name, "region": region, "follower": rng.random() < 0.7}


def traction(rng, scene):
    """A pressure or a traction on a face of a body that is a box; the first is made one."""
    bodies = {name: body for name, body in scene.case["bodies"].items() if not runs(scene, name)}
    if not bodies:
        return
    boxes = [name for name, body in bodies.items() if "box" in body["region"]]
    if not boxes:
        boxes = [next(iter(bodies))]
        low, high = scene.corners[boxes[0]]
        bodies[boxes[0]]["region"] = {"box": {"min": low, "max": high}}
    entry = {"body": rng.choice(boxes), "face": rng.choice(scene.faces)}
    if rng.kind.random() < 0.4:
        entry = _on_surface(rng, scene, bodies)
    if rng.random() < 0.5:
        entry["pressure"] = table(rng, scene, 5.0) if rng.random() < 0.4 else number(rng, -5, 5)
    else:
        varies = rng.random() < 0.4
        entry["traction"] = (
            table(rng, scene, 5.0, scene.dimension) if varies else vector(rng, scene.dimension, 5.0)
        )
    if entry.get("follower") is False or "gravity" not in scene.case or rng.random() < 0.7:
        scene.case["tractions"] = {"load": entry}
        return
    if "region" in entry:
        del entry["pressure" if "pressure" in entry else "traction"]
        low, high = scene.corners[entry["body"]]
        entry["hydrostatic"] = {"level": number(rng, min(low), max(high)), "density": 1.0}
    scene.case["tractions"] = {"load": entry}


def profile(rng, scene):
    """Loads on surfaces have a size along a line, which moves; a stage may move it otherwise."""
    case = scene.case
    periodic = [face[0] for face, kind in case["boundaries"].items() if kind == "periodic"]
    loads = {name: load for name, load in case.get("tractions", {}).items()
             if "region" in load and "hydrostatic" not in load}  # fmt: skip
    changed = False
    for name, load in loads.items():
        along = vector(rng, scene.dimension, 1.0)
        along = [0.0 if "xyz"[d] in periodic else a for d, a in enumerate(along)]
        if not any(along):
            continue
        low, high = scene.corners[load["body"]]
        size = max(b - a for a, b in zip(low, high, strict=True))
        rows = sorted({round(rng.uniform(-size, size), 4) for _ in range(rng.randint(2, 5))})
        rows = rows if len(rows) > 1 else [-size, size]
        most = 2.0 * size / scene.end
        found = {
            "along": along, "from": [number(rng, a, b) for a, b in zip(low, high, strict=True)],
            "velocity": number(rng, -most, most), "beyond": rng.choice(("zero", "hold")),
            "table": [[s, number(rng, -1.0, 1.0)] for s in rows],
        }  # fmt: skip
        if rng.random() < 0.5:
            found["velocity"] = table(rng, scene, most)
        load["profile"] = found
        changed = True
        for stage in case["time"].get("stages", ()):
            if stage.get("tractions", {}).get(name) and rng.random() < 0.5:
                other = {"velocity": number(rng, -most, most)}
                if rng.random() < 0.3:
                    other["from"] = low
                stage["tractions"][name]["profile"] = found | other
    return changed


def _forced(rng, scene, entry):
    """Forces in place of some of a constraint's velocities, with a mass, a spring or a dashpot."""
    low, high = scene.corners[entry["body"]]
    size = min(b - a for a, b in zip(low, high, strict=True))
    volume = math.prod(b - a for a, b in zip(low, high, strict=True))
    most = 0.02 * volume * scene.speed**2 / size
    force = components(rng, scene, most)
    change = {
        "force": force,
        "velocity": [
            None if f is not None else v for f, v in zip(force, entry["velocity"], strict=True)
        ],
    }
    if rng.random() < 0.5:
        change["mass"] = number(rng, 0.1, 2.0) * volume
    if rng.random() < 0.5:
        stiffness = number(rng, 0.0, 2.0) * most / size
        dashpot = number(rng, 0.1, 2.0) * volume * scene.speed / size
        change["spring"] = {"stiffness": stiffness, "dashpot": dashpot}
    return change


def constraint(rng, scene):
    """A half of a body or all of it moves as told."""
    body = rng.choice([*scene.case["bodies"]])
    low, high = (list(corner) for corner in scene.corners[body])
    d = rng.randrange(scene.dimension)
    ends = low if rng.random() < 0.5 else high
    if rng.random() < 0.85:
        ends[d] = 0.5 * (low[d] + high[d])
    velocity = components(rng, scene, 0.1 * scene.speed)
    region = {"box": {"min": low, "max": high}}
    if rng.random() < 0.3:
        middle = [0.5 * (a + b) for a, b in zip(*scene.corners[body], strict=True)]
        normal = [1.0, *vector(rng, scene.dimension - 1, 1.0)]
        region = {"half-space": {"point": middle, "normal": normal}}
    entry = {"body": body, "region": region, "velocity": velocity}
    if rng.kind.random() < 0.3 and body not in scene.case.get("inflow", {}):
        entry |= _forced(rng, scene, entry)
    grips = scene.case.setdefault("constraints", {})
    grips[f"grip{len(grips)}"] = entry


def rotation(rng, scene):
    """Constraints turn by up to half a turn about a place in the body, the axis moving or not."""
    case = scene.case
    entries = [
        entry for entry in case.get("constraints", {}).values()
        if not entry.get("force") and entry["body"] not in case.get("inflow", {})
    ]  # fmt: skip
    if not entries or scene.dimension == 1 or case.get("geometry") == "axisymmetric":
        return False
    for entry in entries:
        low, high = scene.corners[entry["body"]]
        most = 0.1 * scene.speed / max(b - a for a, b in zip(low, high, strict=True))
        turning = {
            "about": [number(rng, a, b) for a, b in zip(low, high, strict=True)],
            "rate": number(rng, -most, most) if rng.random() < 0.5 else table(rng, scene, most),
        }
        velocity = [0.0 if v is None else v for v in entry["velocity"]]
        if scene.dimension == 3:
            turning["axis"] = [1.0, *vector(rng, 2, 1.0)]
            if rng.random() < 0.5:
                along = rng.randrange(3)
                turning["axis"] = [0.0, 0.0, 0.0]
                turning["axis"][along], velocity[along] = rng.choice((-2.0, 1.0)), None
        entry |= {"rotation": turning, "velocity": velocity}
        if None not in velocity and rng.random() < 0.3:
            del entry["velocity"]
    return True
