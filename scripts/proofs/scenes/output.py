"""Features of random scenes that say what a run writes; see `scene_features`."""

from pgimp.physics.derived import DERIVED, OF_STRESS
from proofs.scenes.bodies import number

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
    if any(body.get("configuration") == "initial" for body in scene.case["bodies"].values()):
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


def checkpoints(rng, scene):
    """Some, of which a few are kept."""
    every = {"steps": rng.randint(3, max(4, scene.steps // 4))}
    scene.case["checkpoint"] = {"every": every, "keep": rng.randint(2, 4)}
