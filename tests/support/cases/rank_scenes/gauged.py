"""Gauges of every kind, and derived fields, for scenes that have other things to show."""

from pgimp.physics.derived import DERIVED, OF_STRESS

#: Of each dimension, shapes, contact, loads, both configurations, rings, seams, and what leaves.
GAUGED = (
    "line_leaves", "plane_leaves", "space_gimp", "meeting", "initial", "both_configurations",
    "rings", "round_and_round", "layer", "streams",
)  # fmt: skip


def gauged(case):
    """The case with gauges at its middle, where surfaces may be, and derived fields."""
    D, size = case["dimensions"], case["grid"]["size"]
    faces = case.get("boundaries", {})
    seams = ["xyz".index(face[0]) for face, kind in faces.items() if kind == "periodic"]
    initial = any(body.get("formulation") == "total-lagrangian" for body in case["bodies"].values())
    middle, first = [0.5 * x for x in size], next(iter(case["bodies"]))
    low, high = [0.23 * x for x in size], [0.71 * x for x in size]
    for d in seams:
        if min(low[d], size[d] - high[d]) < case["grid"]["cell"][d]:  # thin: all of it
            low[d], high[d] = 0.0, size[d]
    part = {"box": {"min": low, "max": high}}
    across = [1.0 if d == 0 else 0.0 for d in range(D)]
    plane = {"half-space": {"point": [0.93 * x for x in middle], "normal": across}}
    gauges = {
        "part": {"cut": part, "mean": 0.21, "about": [0.0] * D},
        "gate": {"flux": plane, "mean": 0.1},
        "net": {"flux": part, "within": {"box": {"min": [0.0] * D, "max": middle}}},
        "own": {"cut": part, "bodies": [first]},
    }
    if 0 not in seams:
        gauges["plane"] = {"cut": plane}
    if not seams:
        slanted = {"point": middle, "normal": [1.0, 0.4, -0.3][:D]}
        gauges["slanted"] = {"cut": {"half-space": slanted}, "within": part}
    for face, kind in faces.items():
        lets_go = kind == "unilateral" or "unilateral" in kind
        if kind != "periodic" and not (initial and lets_go):
            d, end = "xyz".index(face[0]), face.endswith("max")  # the part reaches to the wall
            ends = {"min": [*low], "max": [*high]}
            ends["max" if end else "min"][d] = size[d] if end else 0.0
            gauges[f"on-{face}"] = {"wall": face, "within": {"box": ends}, "mean": 1.0}
    if D > 1:
        gauges["level"] = {"level": middle[:-1], "mean": 0.3}
    fields = [*case["output"]["fields"], *DERIVED]
    output = case["output"] | {"fields": fields}
    probes = {
        name: probe | {"fields": [*(OF_STRESS if "place" in probe else DERIVED)]}
        for name, probe in case.get("probes", {}).items()
    }
    return case | {"gauges": gauges, "output": output, "probes": probes}
