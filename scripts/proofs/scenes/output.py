"""Features of random scenes that say what a run writes; see `scene_features`."""

from proofs.scenes.bodies import number

from pgimp.physics.derived import DERIVED, OF_STRESS

FIELDS = ("velocity", "stress", "displacement", "deformation", "pressure", "von-mises", "strain",
          "mass", "density", *DERIVED)  # fmt: skip


def frames(rng, scene):
    """Frames now and then, with any fields but the rank, which differs from run to run."""
    end = scene.end
    every = rng.choice((None, {"steps": rng.randint(3, 30)}, number(rng, 0.1 * end, 0.6 * end)))
    chosen = rng.sample((*FIELDS, *scene.states), rng.randint(0, 6))
    scene.case["output"] |= {"every": every, "fields": chosen}
    if rng.random() < 0.4:
        at = sorted({number(rng, 0.0, 0.99 * end) for _ in range(rng.randint(1, 3))})
        scene.case["output"]["at"] = at


def grid_frames(rng, scene):
    """Frames of the grid."""
    names = rng.sample(("mass", "momentum", "velocity", "force", "contact"), rng.randint(1, 4))
    if any(body.get("formulation") == "total-lagrangian" for body in scene.case["bodies"].values()):
        names = [name for name in names if name != "contact"]
    scene.case["output"]["grid"] = names


def small_files(rng, scene):
    """Fewer digits in frames, or compressed ones."""
    scene.case["output"]["precision"] = rng.choice(("float32", "float64"))
    scene.case["output"]["compression"] = rng.choice(("gzip", "none"))


def history(rng, scene):
    """Lines by steps or by time."""
    every = number(rng, 0.05 * scene.end, 0.5 * scene.end)
    scene.case["history"] = {"every": rng.choice(({"steps": rng.randint(1, 20)}, every))}


def probes(rng, scene):
    """Places in the domain, and particles of bodies."""
    found = scene.case["probes"] = {}
    for name, (low, high) in scene.corners.items():
        at = [number(rng, 0.6 * a + 0.4 * b, 0.4 * a + 0.6 * b)
              for a, b in zip(low, high, strict=True)]  # fmt: skip
        entry = {"place": at} if rng.random() < 0.4 else {"body": name, "at": at}
        if rng.random() < 0.7:
            entry["every"] = {"steps": rng.randint(1, 9)}
        if rng.random() < 0.3:
            known = [*(OF_STRESS if "place" in entry else DERIVED)]
            entry["fields"] = rng.sample(known, rng.randint(1, 4))
        found[f"at-{name}"] = entry


def gauges(rng, scene):
    """Some of every kind, through the middle and off it; a cut has no periodic direction across."""
    case, found, D = scene.case, {}, scene.case["dimensions"]
    size, faces = case["grid"]["size"], case["boundaries"]
    origin = case["grid"].get("origin", [0.0] * D)
    seams = {"xyz".index(face[0]) for face, kind in faces.items() if kind == "periodic"}
    initial = any(body.get("formulation") == "total-lagrangian" for body in case["bodies"].values())
    named = [name for name, body in case["bodies"].items() if "rigid" not in body]
    part = {"box": {"min": [], "max": []}}
    for low, length in zip(origin, size, strict=True):
        ends = sorted((number(rng, 0.26, 0.5), number(rng, 0.51, 0.74)))
        part["box"]["min"].append(low + ends[0] * length)
        part["box"]["max"].append(low + ends[1] * length)
    point = [number(rng, low, high)
             for low, high in zip(part["box"]["min"], part["box"]["max"], strict=True)]  # fmt: skip
    free = [d for d in range(D) if d not in seams]
    narrow = any(case["grid"]["cell"][d] > 0.25 * size[d] for d in seams)
    if not narrow:
        found["part"] = {"cut": part}
        found["net"] = {"flux": part}
    if free:
        normal = [number(rng, 0.2, 1.0) if d in free else 0.0 for d in range(D)]
        found["plane"] = {"cut": {"half-space": {"point": point, "normal": normal}}}
    along = rng.randrange(D)
    normal = [1.0 if d == along else 0.0 for d in range(D)]
    found["gate"] = {"flux": {"half-space": {"point": point, "normal": normal}}, "within": part}
    # A stage may open a face.
    later = [stage.get("boundaries") for stage in case["time"].get("stages", ())]
    for face, kind in faces.items() if not any(later) else ():
        if kind != "periodic" and not (initial and "unilateral" in kind):
            found[f"on-{face}"] = {"wall": face}
            if rng.random() < 0.5:  # what presses on the wall
                d, end = "xyz".index(face[0]), "max" if face.endswith("max") else "min"
                box = {"min": [*part["box"]["min"]], "max": [*part["box"]["max"]]}
                box[end][d] = origin[d] + (size[d] if end == "max" else 0.0)
                found[f"on-{face}"]["within"] = {"box": box}
    if D > 1 and case.get("geometry") != "plane-stress":
        found["level"] = {"level": point[:-1]}
    for entry in found.values():
        if rng.random() < 0.4:
            entry["mean"] = number(rng, 0.05 * scene.end, scene.end)
        if rng.random() < 0.3:
            entry["bodies"] = rng.sample(named, rng.randint(1, len(named)))
    case["gauges"] = found


def checkpoints(rng, scene):
    """Some, of which a few are kept."""
    every = {"steps": rng.randint(3, max(4, scene.steps // 4))}
    scene.case["checkpoint"] = {"every": every, "keep": rng.randint(2, 4)}
