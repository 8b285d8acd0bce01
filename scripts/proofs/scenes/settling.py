"""The feature of random scenes that lets a stage come to rest; see `scene_features`."""

from proofs.scenes.bodies import number


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
    stage = {"name": "rest", "settle": {"tolerance": number(rng, 0.2, 0.9), "steps": 60}}
    still = {"velocity": [0.0] * scene.dimension}
    if stops := [name for name, entry in held.items() if entry and entry["body"] not in gone]:
        stage["constraints"] = dict.fromkeys(stops, still)
    if moves := [face for face, kind in walls.items() if kind and "velocity" in kind]:
        stage["boundaries"] = dict.fromkeys(moves, "fixed")
    if "damping" in case and rng.random() < 0.5:
        stage["damping"] = None
    stages.insert(place, stage)
    return True
