"""The initial configuration, of all bodies of a random scene or of some."""

from proofs.scenes.bodies import number
from proofs.scenes.materials import runs


def _without_hourglass(scene):
    """Take two particles a cell along each direction if there is one along two or more."""
    method = scene.case["method"]
    if method["particles_per_cell"].count(1) > 1:
        method["particles_per_cell"] = [max(2, n) for n in method["particles_per_cell"]]


def initial(rng, scene):
    """All bodies in the initial configuration, without what they cannot meet there.

    Half of them meet others, rigid bodies and walls that let go; else they are alone.
    """
    case = scene.case
    if any(runs(scene, name) for name, body in case["bodies"].items() if "rigid" not in body):
        return
    meets = rng.kind.random() < 0.6
    case["bodies"] = {
        name: body if "rigid" in body else body | {"configuration": "initial"}
        for name, body in case["bodies"].items()
        if "rigid" not in body or (meets and "density" not in body["rigid"])
    }
    _without_hourglass(scene)
    case.pop("escape", None)
    default = [{"bodies": "all", "friction": 0.3}] if meets and "contact" in case else []
    laws = [
        entry for entry in case.pop("contact", [])
        if entry["bodies"] == "all" or all(name in case["bodies"] for name in entry["bodies"])
    ] or default  # fmt: skip
    if laws and len(case["bodies"]) > 1:
        case["contact"] = laws
    case["method"].pop("volume", None)
    for face, kind in case["boundaries"].items():
        if not meets and (kind == "separating" or "separating" in kind):
            case["boundaries"][face] = "slip"


def both(rng, scene):
    """Some bodies in the initial configuration beside others, with one law of contact or none."""
    case = scene.case
    solids = [name for name, body in case["bodies"].items() if "rigid" not in body]
    begun = {name for name in solids if not runs(scene, name) and rng.random() < 0.6}
    if not begun or any("configuration" in body for body in case["bodies"].values()):
        return
    if case["method"]["shape"] == "cpdi-corners":  # refused
        return
    laws = [entry for entry in case.pop("contact", []) if entry["bodies"] == "all"]
    if len(solids) == len(begun):
        begun.discard(solids[0])
    case["bodies"] = {
        name: body | {"configuration": "initial"} if name in begun else body
        for name, body in case["bodies"].items()
        if "density" not in body.get("rigid", {})
    }
    if begun:
        case["method"].pop("volume", None)
        _without_hourglass(scene)
    if len(case["bodies"]) > 1 and (laws or rng.random() < 0.8):
        case["contact"] = laws or [{"bodies": "all", "friction": number(rng, 0.0, 0.5)}]
