"""The initial configuration of bodies of a random scene; axisymmetric and periodic scenes.

There x is the radius; what cannot be on an axis is taken out at the end.
"""

from proofs.scenes.bodies import number
from proofs.scenes.materials import runs


def _without_hourglass(scene):
    """Take two particles a cell along each direction if there is one along two or more."""
    method = scene.case["method"]
    if method["particles-per-cell"].count(1) > 1:
        method["particles-per-cell"] = [max(2, n) for n in method["particles-per-cell"]]


def initial(rng, scene):
    """All bodies in the initial configuration, without what they cannot meet there.

    Half of them meet others, rigid bodies and walls that let go; else they are alone.
    """
    case = scene.case
    if any(runs(scene, name) for name, body in case["bodies"].items() if "rigid" not in body):
        return
    meets = rng.kind.random() < 0.6
    case["bodies"] = {
        name: body if "rigid" in body else body | {"formulation": "total-lagrangian"}
        for name, body in case["bodies"].items()
        if "rigid" not in body or (meets and "density" not in body["rigid"])
    }
    _without_hourglass(scene)
    case.pop("outflow", None)
    default = [{"bodies": "all", "friction": 0.3}] if meets and "contact" in case else []
    laws = [
        entry for entry in case.pop("contact", [])
        if entry["bodies"] == "all" or all(name in case["bodies"] for name in entry["bodies"])
    ] or default  # fmt: skip
    if laws and len(case["bodies"]) > 1:
        case["contact"] = laws
    if (meets or laws) and case["method"]["shape"].startswith(("fuzzy", "bspline")):
        case["method"]["shape"] = "gimp"  # what meets is no wider than cells
        case["method"].pop("size", None)
    case["method"].pop("volume", None)
    for face, kind in case["boundaries"].items():
        if not meets and (kind == "unilateral" or "unilateral" in kind):
            case["boundaries"][face] = "slip"


def cut_cells(rng, scene):
    """Exact cut cells of all bodies, where all are in the initial configuration: none is whole."""
    case = scene.case
    solids = [body for body in case["bodies"].values() if "rigid" not in body]
    if (
        case["method"]["shape"] not in ("gimp", "finite-gimp", "mpm", "cpdi")
        or any(body.get("formulation") != "total-lagrangian" for body in solids)
        or any("points" in body["region"] for body in solids)
    ):
        return False
    for body in solids:
        body.pop("surface", None)
    return True


def averaged(rng, scene):
    """Averaged mass, of all bodies or of some, where they are in the initial configuration."""
    case = scene.case
    begun = [b for b in case["bodies"].values() if b.get("formulation") == "total-lagrangian"]
    if not begun or case["method"]["shape"] == "mpm":
        return False
    if len(begun) == len(case["bodies"]) and rng.random() < 0.6:
        case["method"]["mass"] = "averaged"
        return True
    some = [body for body in begun if rng.random() < 0.7] or begun
    for body in some:
        body["mass"] = "averaged"
    return True


def both(rng, scene):
    """Some bodies in the initial configuration beside others, with one law of contact or none."""
    case = scene.case
    solids = [name for name, body in case["bodies"].items() if "rigid" not in body]
    begun = {name for name in solids if not runs(scene, name) and rng.random() < 0.6}
    if not begun or any("formulation" in body for body in case["bodies"].values()):
        return
    if case["method"]["shape"] == "cpdi-corners":  # refused
        return
    laws = [entry for entry in case.pop("contact", []) if entry["bodies"] == "all"]
    if len(solids) == len(begun):
        begun.discard(solids[0])
    case["bodies"] = {
        name: body | {"formulation": "total-lagrangian"} if name in begun else body
        for name, body in case["bodies"].items()
        if "density" not in body.get("rigid", {})
    }
    if begun:
        case["method"].pop("volume", None)
        _without_hourglass(scene)
    if len(case["bodies"]) > 1 and (laws or rng.random() < 0.8):
        case["contact"] = laws or [{"bodies": "all", "friction": number(rng, 0.0, 0.5)}]


#: Shapes that have weights of rings.
RING_SHAPES = ("gimp", "finite-gimp", "cpdi", "mpm")


def rings(rng, scene):
    """A scene of rings, from the axis on or some cells away."""
    method = scene.case["method"]
    if scene.dimension != 2 or method["shape"] not in RING_SHAPES:
        return False
    scene.case["geometry"] = "axisymmetric"
    away = 0.0 if rng.random() < 0.6 else number(rng, 1.0, 20.0) * scene.cell[0]
    scene.case["grid"]["origin"][0] = away
    return True


def _along(value):
    """A vector, or one over time, without its component along the radius."""
    if isinstance(value, dict):
        return {"table": [[time, [0.0, row[1]]] for time, row in value["table"]]}
    return None if value is None else [0.0, value[1]]


def _flowing(entry):
    """Whether an entry of a material flows."""
    from pgimp.physics.materials import MATERIALS

    law = MATERIALS.get(entry["model"])  # of one's own there is none
    try:
        return law is not None and law.model_validate(entry).flow_speed > 0.0
    except ValueError:  # refused, as the scene will be
        return False


def along_the_axis(rng, scene):
    """In scenes of rings bodies and gravity move along the axis alone; what flows is a solid."""
    case = scene.case
    if case.get("geometry") != "axisymmetric":
        return
    solid = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3}
    for name, entry in case["materials"].items():
        if _flowing(entry):
            case["materials"][name] = solid | {"density": entry["density"]}
            for stage in case["time"].get("stages", ()):  # which change what it was
                stage.get("materials", {}).pop(name, None)
    for part in (case, *case["time"].get("stages", ())):
        if "gravity" in part:
            part["gravity"] = _along(part["gravity"])
        for key in ("boundaries", "outflow"):
            if case["grid"]["origin"][0] == 0.0:
                part.get(key, {}).pop("x-min", None)
    for body in case["bodies"].values():
        if "density" in body.get("rigid", {}):
            velocity = body.get("velocity")
            if isinstance(velocity, dict):
                velocity = velocity.get("translation")
            body["velocity"] = _along(velocity) or [0.0, 0.0]
            if "force" in body["rigid"]:
                body["rigid"]["force"] = _along(body["rigid"]["force"])
        elif "rigid" in body:
            body["rigid"] = {
                key: _along(v) for key, v in body["rigid"].items() if key == "velocity"
            }
        else:
            velocity = body.get("velocity")
            if isinstance(velocity, dict):
                velocity = velocity.get("translation")
            body["velocity"] = _along(velocity) or [0.0, 0.0]
    _alike(case)


def _alike(case):
    """All bodies of a material are in the initial configuration, or none is."""
    bodies = [body for body in case["bodies"].values() if "rigid" not in body]
    if {body.get("formulation") for body in bodies} != {"total-lagrangian"}:
        for body in case["bodies"].values():
            body.pop("formulation", None)


def plates(rng, scene):
    """A scene in plane stress, without mean dilatation, of laws that it knows."""
    case = scene.case
    if scene.dimension != 2 or "geometry" in case:
        return False
    case["geometry"] = "plane-stress"
    case["method"].pop("volumetric", None)
    for name, entry in case["materials"].items():
        if entry["model"] not in ("hooke", "neo-hookean", "von-mises"):
            case["materials"][name] = {
                "model": "neo-hookean", "young": 100.0, "poisson": 0.3,
                "density": entry["density"],
            }  # fmt: skip
    metal = any(entry["model"] == "von-mises" for entry in case["materials"].values())
    scene.states = ("plastic-strain",) if metal else ()
    return True


def _is_short(scene, body, axes):
    """Whether the images of a rigid body keep apart, also when it has turned."""
    from pgimp.physics.rigid import RigidBody

    region = RigidBody.model_validate(body).region
    if any(part.FROM_FILE for part in region.simple()):
        return False
    low, high = region.bounds()
    size = sum((b - a) ** 2 for a, b in zip(low, high, strict=True)) ** 0.5
    size += 2.0 * max(scene.cell)
    lengths = (scene.cells[axis] * scene.cell[axis] for axis in axes)
    return size < min(lengths) - 2.1 * sum(scene.cell)


def _turn_along(case, axes):
    """Let constraints turn no more but about the one periodic direction."""
    for name, entry in case.get("constraints", {}).items():
        axis = entry.get("rotation", {}).get("axis", [0.0, 0.0, 1.0])
        along = [d for d, each in enumerate(axis) if each]
        if "rotation" not in entry or along == axes:
            continue
        about = entry.pop("rotation")["about"]
        entry.setdefault("velocity", [0.0] * len(about))
        for stage in case["time"].get("stages", ()):
            (stage.get("constraints", {}).get(name) or {}).pop("rotation", None)


def periodic(rng, scene):
    """One or more directions, x in most scenes, without what no periodic domain has."""
    from pgimp.physics.shapes import SHAPES

    case = scene.case
    shape = SHAPES[case["method"]["shape"]].model_validate(case["method"])
    axes = [
        axis for axis in range(scene.dimension)
        if rng.kind.random() < (0.75, 0.5, 0.4)[axis] and scene.cells[axis] >= shape.vertices
    ]  # fmt: skip
    if case.get("geometry") == "axisymmetric":
        axes = [axis for axis in axes if axis == 1]
    if not axes:
        return False
    faces = [f"{'xyz'[axis]}-{end}" for axis in axes for end in ("min", "max")]
    rigid = [name for name, body in case["bodies"].items()
             if "rigid" in body and not _is_short(scene, body, axes)]  # fmt: skip
    for name in rigid:
        del case["bodies"][name]
    laws = [
        entry for entry in case.pop("contact", [])
        if entry["bodies"] == "all" or not set(entry["bodies"]) & set(rigid)
    ]  # fmt: skip
    if laws and len(case["bodies"]) > 1:
        case["contact"] = laws
    case.pop("body-force", None)
    loads = {name: load for name, load in case.pop("tractions", {}).items()
             if load.get("face") not in faces}  # fmt: skip
    if loads:
        case["tractions"] = loads
    for body in case["bodies"].values():
        body.pop("formulation", None)
    case["boundaries"] |= dict.fromkeys(faces, "periodic")
    _turn_along(case, axes)
    for part in (case, *case["time"].get("stages", ())):
        if not loads:
            part.pop("tractions", None)
        for face in faces:
            part.get("outflow", {}).pop(face, None)
            if part is not case:
                part.get("boundaries", {}).pop(face, None)
        if part is not case and rigid:
            part.pop("contact", None)
            part["remove"] = [name for name in part.get("remove", []) if name not in rigid]
    return True


def relaxation(rng, scene):
    """Particles' velocities relax towards the grid's."""
    scene.case["method"]["pic-damping"] = number(rng, 0.5, 20.0)


def splines(rng, scene):
    """B-splines in place of another shape."""
    shape = rng.kind.choice(("bspline-quadratic", "bspline-cubic"))
    ghost = {"wall": "ghost"} if rng.kind.random() < 0.3 else {}
    scene.case["method"] = {"shape": shape, "particles-per-cell": scene.per_cell} | ghost


def of_corners(rng, scene):
    """Parallelograms in place of another shape."""
    scene.case["method"] = {"shape": "cpdi-corners", "particles-per-cell": scene.per_cell}
