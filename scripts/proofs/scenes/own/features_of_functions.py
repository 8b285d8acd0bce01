"""Features of random scenes by functions of one's own, those of `random_functions.py`."""

from proofs.scenes.bodies import number


def own_force(rng, scene):
    """A body force of place, velocity and time."""
    most, wave = 0.05 * scene.speed**2 / max(scene.cells), number(rng, 0.1, 1.0)
    strength = {"strength": 0.1 * number(rng, -most, most), "rate": number(rng, 0, 6) / scene.end}
    if rng.kind.random() < 0.5:
        scene.case["body-force"] = {"function": "pulling", "parameters": strength}
        return
    more = {"drag": number(rng, 0.0, 1.0) / scene.end, "wave": wave}
    scene.case["body-force"] = {"function": "swaying", "parameters": strength | more}


def own_velocity(rng, scene):
    """Some bodies begin with a velocity that varies in space."""
    for name, body in scene.case["bodies"].items():
        solid = "rigid" not in body and "points" not in body["region"]
        if solid and name not in scene.case.get("inflow", {}) and rng.random() < 0.6:
            size = 0.05 * scene.speed / max(1.0, *(abs(x) for x in scene.corners[name][1]))
            parameters = {"size": number(rng, -size, size), "wave": number(rng, 0.1, 1.0)}
            body["velocity"] = {"function": "rippling", "parameters": parameters}


def own_motion(rng, scene):
    """Some of what constraints hold moves as a function of place and time says, in all stages."""
    case = scene.case
    periodic = "periodic" in case.get("boundaries", {}).values()
    stages = case["time"].get("stages", ())
    grips = {
        name: entry for name, entry in case.get("constraints", {}).items()
        if not (entry.get("force") or entry.get("rotation") or name in case.get("inflow", {}))
    }  # fmt: skip
    settles = any("equilibrate" in stage for stage in (case.get("start") or {}, *stages))
    if not grips or periodic or settles:
        return False
    for name, entry in grips.items():
        size = 0.02 * scene.speed / max(1.0, *(abs(x) for x in scene.corners[entry["body"]][1]))
        parameters = {"size": number(rng, -size, size), "wave": number(rng, 0.1, 1.0)}
        parameters["rate"] = number(rng, 0.0, 6.0) / scene.end
        entry["velocity"] = {"function": "drifting", "parameters": parameters}
        for stage in stages:
            (stage.get("constraints", {}).get(name) or {}).pop("velocity", None)
    return True


def own_stress(rng, scene):
    """Bodies begin with a stress that varies in space."""
    case = scene.case
    if (
        case.get("start")
        or case.get("geometry") == "plane-stress"
        or any(
            body.get("formulation") or "points" in body.get("region", {})
            for body in case["bodies"].values()
        )
    ):
        return False
    parameters = {"p": number(rng, -0.5, 0.5), "wave": number(rng, 0.1, 1.0), "mean": 0.0}
    if any(law["model"] == "cam-clay" for law in case["materials"].values()):  # bears no tension
        parameters["mean"] = -1.2 * abs(parameters["p"]) - 0.01
    case["start"] = {"stress": {"function": "squeezing", "parameters": parameters}}
    return True


def own_coefficients(rng, scene):
    """Gravity by a coefficient of time, and a density by one of space."""
    gravity = scene.case.get("gravity")
    if isinstance(gravity, list) and all(isinstance(g, float) for g in gravity):
        rate = number(rng, 1.0, 9.0) / scene.end
        scene.case["gravity"] = [
            {"function": "breathing", "parameters": {"mean": g, "swing": 0.5 * g, "rate": rate}}
            for g in gravity
        ]
    for law in scene.case["materials"].values():
        if law["model"] == "neo-hookean" and isinstance(law["density"], float):
            wave = number(rng, 0.1, 1.0)
            parameters = {"mean": law["density"], "part": 0.2, "wave": wave}
            law["density"] = {"function": "patchy", "parameters": parameters}
