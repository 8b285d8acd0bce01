"""The features of random scenes that let a run have stages; see `scene_features`.

Little of what a stage changes needs other kernels, which would take longer than the scene.
"""

from proofs.scenes.bodies import number, vector

#: By model: a parameter that may change, and by what factor.
PARAMETERS = {
    "von-mises": ("yield-stress", 0.4, 1.5), "johnson-cook": ("a", 0.4, 1.5),
    "drucker-prager": ("friction-angle", 1.0, 1.3), "mohr-coulomb": ("friction-angle", 1.0, 1.3),
    "cam-clay": ("m", 0.8, 1.2), "mu-i": ("mu-2", 1.0, 1.5), "newtonian": ("bulk", 0.5, 1.2),
    "bingham": ("yield-stress", 0.5, 2.0), "ideal-gas": None,
}  # fmt: skip
#: Numbers of materials that may be a third larger or smaller, whatever the others are.
VARY = ("young", "density", "poisson", "yield-stress", "a", "bulk", "shear-viscosity", "energy",
        "damage", "toughness", "shear")  # fmt: skip


def stages(rng, scene):
    """One or two stages after the first, each with some changes."""
    time = scene.case["time"]
    count = rng.choice((1, 1, 2))
    cuts = sorted(rng.sample(range(4, scene.steps), count))
    last, fixed = time["end"], not isinstance(time["step"], dict)
    unit = time["step"] if fixed else last / scene.steps
    ends = [round(cut * unit, 12) for cut in cuts] + [last]
    time["end"], time["stages"] = ends[0], []
    now = {key: dict(scene.case.get(key, {})) for key in (
        "materials", "bodies", "boundaries", "tractions", "constraints", "outflow"
    )}  # fmt: skip
    for i in range(count):
        stage = {"name": f"stage{i}", "end": ends[i + 1]}
        for change in CHANGES:
            if rng.random() < 0.45:
                change(rng, scene, now, stage)
        if fixed and rng.random() < 0.25:
            steps = rng.randint(1, 30)
            length = (ends[i + 1] - ends[i]) / steps
            if length <= 1.2 * time["step"] and i == count - 1:
                stage["step"] = length
        time["stages"].append(stage)


def settling(rng, scene):
    """A stage between the others, or the last one, in which all that is held stands still."""
    case = scene.case
    rigid = [body["rigid"] for body in case["bodies"].values() if "rigid" in body]
    if "exact" in case or any(rigid):  # they move
        return False
    stages = case["time"].setdefault("stages", [])
    place = rng.randint(0, len(stages))
    held, walls = dict(case.get("constraints", {})), dict(case.get("boundaries", {}))
    gone = set()
    for part in stages[:place]:
        for name, entry in part.get("constraints", {}).items():
            held[name] = entry and {**(held.get(name) or {}), **entry}
        walls |= part.get("boundaries", {})
        gone |= set(part.get("remove", ()))
    stage = {"name": "rest", "equilibrate": {"tolerance": number(rng, 0.2, 0.9), "steps": 200}}
    still = {"velocity": [0.0] * scene.dimension}
    if stops := [name for name, entry in held.items() if entry and entry["body"] not in gone]:
        freed = still | {"force": [], "mass": 0.0, "spring": None}
        stage["constraints"] = {n: freed if held[n].get("force") else still for n in stops}
        for name in stops:
            if held[name].get("rotation"):
                stage["constraints"][name] = still | {"rotation": None}
    if moves := [face for face, kind in walls.items() if kind and "velocity" in kind]:
        stage["boundaries"] = dict.fromkeys(moves, "fixed")
    if "damping" in case and rng.random() < 0.5:
        stage["damping"] = None
    stages.insert(place, stage)
    return True


def removed(rng, scene, now, stage):
    """A body is taken out, or a rigid one."""
    solid = [name for name, body in now["bodies"].items() if "rigid" not in body]
    rigid = [name for name in now["bodies"] if name not in solid]
    chosen = rng.choice(rigid) if rigid and rng.random() < 0.3 else None
    if chosen is None and len(solid) > 1:
        chosen = rng.choice(solid)
    if chosen:
        stage["remove"] = [chosen]
        del now["bodies"][chosen]
        loads = now["tractions"].items()
        now["tractions"] = {name: load for name, load in loads if load["body"] != chosen}


def parameters(rng, scene, now, stage):
    """Materials become weaker or stiffer."""
    for name, entry in now["materials"].items():
        parameter = PARAMETERS.get(entry["model"], ("young", 0.4, 1.2))
        if any(isinstance(entry.get(key), dict) and key != "damage" for key in VARY) or (
            isinstance(entry.get("damage"), dict) and "d1" not in entry["damage"]
        ):
            continue  # what varies in space stays what it is
        if parameter and rng.random() < 0.7:
            key, least, most = parameter
            entry = now["materials"][name] = dict(entry)
            entry[key] = number(rng, least, most) * entry[key]
            stage.setdefault("materials", {})[name] = {key: entry[key]}


def strength(rng, scene, now, stage):
    """Soils are weaker, or again as strong as they were."""
    soils = [each for each in now["materials"].values() if "friction-angle" in each]
    if soils and not any(isinstance(v, dict) for each in soils for v in each.values()):
        stage["strength-reduction"] = (
            {"factor": number(rng, 1.0, 1.5)} if rng.random() < 0.7 else None
        )


def gravity(rng, scene, now, stage):
    """Another gravity, or none."""
    most = 0.05 * scene.speed**2 / max(scene.cells)
    stage["gravity"] = vector(rng, scene.dimension, most) if rng.random() < 0.7 else None


def walls(rng, scene, now, stage):
    """A face holds otherwise, or lets go."""
    faces = now["boundaries"]
    for face, kind in list(faces.items()):
        separates = kind == "unilateral" or (isinstance(kind, dict) and "unilateral" in kind)
        if separates or rng.random() < 0.5:
            continue
        ways = ("fixed", "slip", None)
        if any("absorbing" in each for each in scene.case["boundaries"].values()):
            ways = (*ways, "absorbing")
        other = rng.choice(ways) if len(faces) > 1 else "slip"
        stage.setdefault("boundaries", {})[face] = other
        faces[face] = other
        if other is None:
            del faces[face]
            if scene.case.get("outflow") and rng.random() < 0.95:
                stage.setdefault("outflow", {})[face] = "remove"


def tractions(rng, scene, now, stage):
    """A traction is another, or ends where there is another."""
    for name, entry in now["tractions"].items():
        if "hydrostatic" in entry:
            stage["tractions"] = {
                name: {"hydrostatic": {"level": number(rng, 0.0, 5.0), "density": 1.0}}
            }
        elif "pressure" in entry:
            stage["tractions"] = {name: {"pressure": number(rng, -5, 5)}}
        else:
            stage["tractions"] = {name: {"traction": vector(rng, scene.dimension, 5.0)}}


def constraints(rng, scene, now, stage):
    """A constraint moves otherwise, holds others, ends, or begins."""
    had, names = now["constraints"], [*now["bodies"]]
    solid = [name for name in names if "rigid" not in now["bodies"][name]]
    for name, entry in list(had.items()):
        if entry["body"] not in solid:
            continue
        most = 0.1 * scene.speed
        velocity = [number(rng, -most, most) for _ in range(scene.dimension)]
        if rng.random() < 0.3:
            velocity[rng.randrange(scene.dimension)] = None
        change = {"velocity": velocity}
        if entry.get("force"):
            change |= {"force": [], "mass": 0.0, "spring": None}
        if all(each is None for each in velocity):
            change["velocity"] = [0.0] * scene.dimension
        if entry.get("rotation"):  # turns otherwise, or no more
            change |= _turned(rng, entry, change)
        if len(had) > 1 and rng.random() < 0.5:
            change = None
            del had[name]
        elif rng.random() < 0.4:
            low, high = scene.corners[entry["body"]]
            change["region"] = {"ball": {
                "centre": [0.5 * (a + b) for a, b in zip(low, high, strict=True)],
                "radius": 0.6 * max(b - a for a, b in zip(low, high, strict=True)),
            }}  # fmt: skip
        stage.setdefault("constraints", {})[name] = change


def _turned(rng, entry, change):
    """Keys that change of a constraint that turns."""
    if rng.random() < 0.5:
        return {"rotation": None}
    turning, velocity = entry["rotation"], [v or 0.0 for v in change["velocity"]]
    if turning.get("axis", [1.0, 1.0]).count(0.0) == 2:
        velocity = [None if n else v for n, v in zip(turning["axis"], velocity, strict=True)]
    return {"rotation": {**turning, "rate": number(rng, -0.5, 0.5)}, "velocity": velocity}


def writing(rng, scene, now, stage):
    """Frames and lines at other times."""
    stage["history"] = {"every": {"steps": rng.randint(1, 9)}}
    if rng.random() < 0.5:
        stage["output"] = {"every": {"steps": rng.randint(3, 20)}}


def damping(rng, scene, now, stage):
    """Velocities relax otherwise; a scene without that has other kernels."""
    if "pic-damping" in scene.case["method"]:
        stage["method"] = {"pic-damping": number(rng, 0.5, 20.0)}


def friction(rng, scene, now, stage):
    """Bodies that meet slide otherwise."""
    entries = [dict(entry) for entry in scene.case.get("contact", [])]
    for entry in entries:
        names = entry["bodies"]
        if names != "all" and not set(names) <= set(now["bodies"]):
            return
        if entry.get("law", "friction") == "friction":
            entry["friction"] = number(rng, 0.0, 1.0)
    if entries and len(now["bodies"]) > 1:
        stage["contact"] = entries


CHANGES = (
    removed, parameters, strength, gravity, walls, tractions, constraints, writing, damping,
    friction,
)  # fmt: skip
