"""The generator of random scenes: a table of features, each of which adds itself to a case.

To add one, say a load: write a function ``(rng, scene) -> None`` that changes ``scene.case``, the
dictionary of a case file (and ``scene.files``, files by name, if the case names any), and returns
without a change where it does not fit, perhaps False, to be not named. Then add a line to
`FEATURES`: its name, the function, the part of scenes that get it, and whether it changes what
Numba compiles (another type or number of parameters). What is compiled is chosen once for a group
of scenes, as compiling takes longer than running: such a feature is in all scenes of a group or in
none, and draws what is compiled by ``rng.kind``, all else by `rng`. Features come in the order of
the table. A new kind of region goes into `bodies.REGIONS`, a material into `materials.MATERIALS`.
"""

import random
from typing import NamedTuple

from proofs.scenes.bodies import add_bodies, mass_scaling, number, thin, vector
from proofs.scenes.configurations import (
    along_the_axis,
    averaged,
    both,
    cut_cells,
    initial,
    of_corners,
    periodic,
    plates,
    relaxation,
    rings,
    splines,
)
from proofs.scenes.contact import contact, free, rigid_bodies
from proofs.scenes.loads import (
    components,
    constraint,
    damping,
    gravity,
    over_time,
    profile,
    rotation,
    traction,
    water,
    weight_above,
)
from proofs.scenes.materials import flows, materials, memory, metals, varied, viscosity
from proofs.scenes.output import (
    checkpoints,
    frames,
    gauges,
    grid_frames,
    history,
    probes,
    small_files,
)
from proofs.scenes.own.features_of_functions import (
    own_coefficients,
    own_force,
    own_motion,
    own_stress,
    own_velocity,
)
from proofs.scenes.stages import settling, stages

SHAPES = ("gimp", "cpdi", "mpm", "finite-gimp", "fuzzy-constant", "fuzzy-nearest")
BOXES = ("gimp", "finite-gimp", "cpdi")
WALLS = ("fixed", "slip", "unilateral", "moving")


class Chance(random.Random):
    """The numbers of a feature in a scene; those of `kind` are the same for all of a group.

    Each feature has its own, so that one that is added or changed leaves the others as they were.
    """

    def __init__(self, seed, number, group, feature):
        super().__init__(f"{seed} scene {number} {feature}")
        self.kind = random.Random(f"{seed} group {group} {feature}")


class Scene:
    """A case that is being made up, and the files that it names."""

    def __init__(self):
        self.case, self.files, self.corners = {}, {}, {}
        self.states = ()

    @property
    def faces(self):
        return [f"{axis}-{end}" for axis in "xyz"[: self.dimension] for end in ("min", "max")]


def domain(rng, scene):
    """Long along x, so that many ranks have work; cells of any size, an origin anywhere."""
    D = scene.dimension = rng.kind.choice((1, 2, 2, 3, 3, 3))
    scene.cells = [rng.randint(8, 26), rng.randint(4, 8), rng.randint(3, 6)][:D]
    scene.cell = [rng.choice((1.0, 1.0, 0.5, 0.3))] * D
    if rng.random() < 0.4:
        scene.cell = [number(rng, 0.7, 1.3) for _ in range(D)]
    size = [n * h for n, h in zip(scene.cells, scene.cell, strict=True)]
    origin = [0.0] * D if rng.random() < 0.6 else vector(rng, D, 5.0)
    scene.case |= {
        "format": 1,
        "dimensions": D,
        "grid": {"origin": origin, "size": size, "cell": scene.cell},
        "materials": {},
        "bodies": {},
        "boundaries": {},
        "output": {},
    }


def method(rng, scene):
    """One of the shapes with its options."""
    shape, counts = rng.kind.choice(SHAPES), (1, 2, 2, 3) if scene.dimension < 3 else (1, 1, 2)
    scene.per_cell = [rng.choice(counts) for _ in scene.cells]
    entry = {"shape": shape, "particles-per-cell": scene.per_cell}
    if shape in ("mpm", "gimp") and rng.kind.random() < 0.3:
        entry["volume"] = "initial"
    if shape.startswith("fuzzy"):
        entry |= {"size": rng.kind.choice(("tracked", "fixed"))}
        entry |= {"wall": rng.kind.choice(("mirror", "mirror", "ghost"))}
    scene.case["method"] = entry


def of_method(shapes=None, **entries):
    """A feature that adds keys to the method, of all shapes or of some."""

    def add(rng, scene):
        if not shapes or scene.case["method"]["shape"] in shapes:
            scene.case["method"] |= entries

    return add


def courant(rng, scene):
    """Pgimp chooses the Courant number, and watches the energy."""
    scene.case["time"]["step"] = {"courant": "auto"}
    scene.case["time"]["end"] = 3.0 * scene.end


def long(rng, scene):
    """Courant control, and twelve times as many steps, so that vibrations might gain energy."""
    if not isinstance(scene.case["time"]["step"], dict):
        scene.case["time"]["step"] = {"courant": number(rng, 0.15, 0.35)}
    scene.case["time"]["end"] = 12.0 * scene.end


def time(rng, scene):
    """Fixed steps, or Courant control; 20 to 60 of them."""
    steps, courant = rng.randint(20, 60), number(rng, 0.08, 0.35)
    step = float(f"{courant * min(scene.cell) / (1.2 * scene.speed):.3g}")
    scene.steps, scene.end = steps, round(steps * step, 12)
    scene.case["time"] = {"end": scene.end, "step": step}
    if rng.random() < 0.35:
        scene.case["time"]["step"] = {"courant": courant}


def walls(rng, scene):
    """Conditions on some faces."""
    for face in scene.faces:
        kind = rng.kind.choice(WALLS) if rng.kind.random() < 0.45 else None
        if kind == "moving":
            most = 0.05 * scene.speed
            velocity = components(rng, scene, most)
            if rng.random() < 0.9:  # else it may let particles through, or pull them out
                inwards = number(rng, 0.0, most) * (1.0 if face.endswith("min") else -1.0)
                velocity["xyz".index(face[0])] = inwards if rng.random() < 0.5 else 0.0
            kind = {"velocity": velocity}
        if kind:
            scene.case["boundaries"][face] = kind


def rough(rng, scene):
    """Unilateral walls have friction."""
    for face, kind in scene.case["boundaries"].items():
        if kind == "unilateral":
            most = number(rng, 0.05, 1.0)
            friction = most if rng.random() < 0.6 else {"static": most, "kinetic": 0.5 * most}
            scene.case["boundaries"][face] = {"unilateral": {"friction": friction}}


def absorbing(rng, scene):
    """Some faces absorb; not those across the radius."""
    axial = scene.case.get("geometry") == "axisymmetric"
    faces = [face for face in scene.faces if not (axial and face.startswith("x"))]
    chosen = [face for face in faces if rng.kind.random() < 0.4] or faces[-1:]
    for face in chosen:
        held = {"absorbing": {"held": "fixed"}}
        scene.case["boundaries"][face] = "absorbing" if rng.random() < 0.7 else held


def escape(rng, scene):
    """Most faces that are open let particles out; one that does not may end the run."""
    open_faces = [face for face in scene.faces if face not in scene.case["boundaries"]]
    ways = {face: "remove" if rng.random() < 0.97 else "stop" for face in open_faces}
    scene.case["outflow"] = ways


def sinks(rng, scene):
    """One or two regions anywhere take out what comes into them."""
    bodies = scene.case["bodies"].values()
    if all(body.get("formulation") == "total-lagrangian" for body in bodies if "rigid" not in body):
        return False
    for i in range(rng.choice((1, 1, 2))):
        pairs = zip(*(scene.case["grid"][key] for key in ("origin", "size")), strict=True)
        centre = [a + rng.uniform(0.0, 1.0) * size for a, size in pairs]
        reach = [rng.uniform(0.5, 3.0) * h for h in scene.cell]
        box = {end: [x + sign * r for x, r in zip(centre, reach, strict=True)]
               for end, sign in (("min", -1.0), ("max", 1.0))}  # fmt: skip
        ball = {"centre": centre, "radius": rng.uniform(0.5, 3.0) * min(scene.cell)}
        region = {"ball": ball} if scene.dimension > 1 and rng.random() < 0.4 else {"box": box}
        scene.case.setdefault("outflow", {})[f"sink{i}"] = {"region": region}
    return True


class Feature(NamedTuple):
    """A line of the table: see the head of this file."""

    name: str
    add: object
    share: float = 1.0
    compiled: bool = False


FEATURES = (
    Feature("domain", domain),
    Feature("method", method),
    Feature("B-splines", splines, 0.15, compiled=True),
    Feature("corners", of_corners, 0.06, compiled=True),
    Feature("rings", rings, 0.3, compiled=True),
    Feature("mirrors", of_method((*BOXES, "cpdi-corners"), wall="mirror"), 0.4, compiled=True),
    Feature("affine", of_method(affine=True), 0.35, compiled=True),
    Feature("mean dilatation", of_method(BOXES, volumetric="b-bar"), 0.35, compiled=True),
    Feature("relaxation", relaxation, 0.15, compiled=True),
    Feature("materials", materials),
    Feature("memory", memory, 0.2, compiled=True),
    Feature("metals", metals, 0.2, compiled=True),
    Feature("flows", flows, 0.35, compiled=True),
    Feature("viscosity", viscosity, 0.2, compiled=True),
    Feature("plane stress", plates, 0.12, compiled=True),
    Feature("time", time),
    Feature("steps chosen", courant, 0.12, compiled=True),
    Feature("many periods", long, 0.05, compiled=True),
    Feature("bodies", add_bodies),
    Feature("thin bodies", thin, 0.3),
    Feature("walls", walls, 0.7, compiled=True),
    Feature("rough walls", rough, 0.3, compiled=True),
    Feature("absorbing faces", absorbing, 0.12, compiled=True),
    Feature("outflow", escape, 0.95),
    Feature("gravity", gravity, 0.5),
    Feature("traction", traction, 0.25, compiled=True),
    Feature("constraint", constraint, 0.25, compiled=True),
    Feature("second constraint", constraint, 0.05, compiled=True),
    Feature("rotation", rotation, 0.3, compiled=True),
    Feature("rigid bodies", rigid_bodies, 0.3, compiled=True),
    Feature("free body", free, 0.12, compiled=True),
    Feature("contact", contact, 0.35, compiled=True),
    Feature("initial configuration", initial, 0.2, compiled=True),
    Feature("both configurations", both, 0.12, compiled=True),
    Feature("weight above", weight_above, 0.12, compiled=True),
    Feature("damping", damping, 0.2, compiled=True),
    Feature("variation", varied, 0.25, compiled=True),
    Feature("functions of time", over_time, 0.4),
    Feature("stages", stages, 0.25),
    Feature("along the axis", along_the_axis),
    Feature("sinks", sinks, 0.2, compiled=True),
    Feature("periodic faces", periodic, 0.2, compiled=True),
    Feature("settling", settling, 0.1, compiled=True),
    Feature("cut cells", cut_cells, 0.7, compiled=True),
    Feature("averaged mass", averaged, 0.5, compiled=True),
    Feature("body force of one's own", own_force, 0.15, compiled=True),
    Feature("velocity of one's own", own_velocity, 0.15),
    Feature("motion of one's own", own_motion, 0.3, compiled=True),
    Feature("stress of one's own", own_stress, 0.08, compiled=True),
    Feature("coefficients of one's own", own_coefficients, 0.12, compiled=True),
    Feature("water", water, 0.12, compiled=True),
    Feature("mass scaling", mass_scaling, 0.1),
    Feature("moving load", profile, 0.5, compiled=True),
    Feature("frames", frames),
    Feature("grid frames", grid_frames, 0.4),
    Feature("precision and compression", small_files, 0.4),
    Feature("history", history),
    Feature("probes", probes, 0.5),
    Feature("gauges", gauges, 0.3),
    Feature("checkpoints", checkpoints),
)


def make(seed, number, group):
    """A random scene: its case, the files it names, and the names of its features.

    `seed`, `number` and `group` are of the proof, the scene, and those that share what is compiled.
    """
    scene, names = Scene(), []
    for feature in FEATURES:
        rng = Chance(seed, number, group, feature.name)
        chance = rng.kind if feature.compiled else rng
        taken = feature.share == 1.0 or chance.random() < feature.share
        if taken and feature.add(rng, scene) is not False:
            names.append(feature.name)
    title = f"scene {number} of group {group}, seed {seed}"
    return {"title": title} | scene.case, scene.files, names
