"""The generator of random scenes: a table of features, each of which adds itself to a case.

To add one, say a load: write a function ``(rng, scene) -> None`` that changes ``scene.case``, the
dictionary of a case file (and ``scene.files``, files by name, if the case names any), and returns
without a change where it does not fit. Then add a line to `FEATURES`: its name, the function, the
part of scenes that get it, and whether it changes what Numba compiles (another type or number of
parameters). What is compiled is chosen once for a group of scenes, as compiling takes longer than
running: such a feature is in all scenes of a group or in none, and where it draws what is compiled
it uses ``rng.kind``, which draws the same for all of them. Everything else is drawn from `rng`.
Features come in the order of the table: the domain first, then what lies
in it. A new kind of region goes into `scene_bodies.REGIONS`, a new material into `MATERIALS`.
"""

import math
import random
from typing import NamedTuple

from scene_bodies import add_bodies, ball, box, middle, number, union, vector
from scene_output import checkpoints, frames, grid_frames, history, probes, small_files
from scene_stages import VARY, stages

SHAPES = ("gimp", "cpdi", "mpm", "finite-gimp", "fuzzy-constant", "fuzzy-nearest")
MATERIALS = {
    "soft": {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0},
    "stiff": {"model": "hooke", "young": 300.0, "poisson": 0.25, "density": 2.0},
    "bar": {"model": "linear-1d", "young": 100.0, "density": 1.0},
    "heavy": {"model": "neo-hookean", "young": 80.0, "poisson": 0.0, "density": 3.0},
}
WALLS = ("fixed", "slip", "separating", "moving")


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
        """Names of the domain's faces."""
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
    shape = rng.kind.choice(SHAPES)
    scene.per_cell = [rng.choice((1, 2, 2, 3) if scene.dimension < 3 else (1, 1, 2))
                      for _ in scene.cells]  # fmt: skip
    entry = {"shape": shape, "particles_per_cell": scene.per_cell}
    if shape in ("mpm", "gimp") and rng.kind.random() < 0.3:
        entry["volume"] = "initial"
    if shape.startswith("fuzzy"):
        entry |= {"size": rng.kind.choice(("tracked", "fixed"))}
        entry |= {"wall": rng.kind.choice(("mirror", "mirror", "ghost"))}
    scene.case["method"] = entry


def splines(rng, scene):
    """B-splines in place of another shape."""
    method = {"shape": rng.kind.choice(("bspline-quadratic", "bspline-cubic"))}
    scene.case["method"] = method | {"particles_per_cell": scene.per_cell}
    if rng.kind.random() < 0.3:
        scene.case["method"]["wall"] = "ghost"


def mirrors(rng, scene):
    """Walls reflect what boxes carry beyond them."""
    if scene.case["method"]["shape"] in ("gimp", "finite-gimp", "cpdi"):
        scene.case["method"]["wall"] = "mirror"


def courant(rng, scene):
    """Pgimp chooses the Courant number, and watches the energy."""
    scene.case["time"]["step"] = {"courant": "auto"}
    scene.case["time"]["end"] = 3.0 * scene.end


def materials(rng, scene):
    """One, or two models with a parameter that differs."""
    names = ["bar"] if scene.dimension == 1 else ["soft", "stiff"]
    chosen = rng.kind.choice(([names[0]], [names[-1]], names, names, [*names, "heavy"]))
    if scene.dimension == 1 and "heavy" in chosen:
        chosen = ["bar", "light"]
    every = MATERIALS | {"light": MATERIALS["bar"] | {"density": number(rng, 0.2, 0.9)}}
    scene.case["materials"] = {name: dict(every[name]) for name in dict.fromkeys(chosen)}
    # All that are declared are used, if there are as many bodies: what is not used is not compiled.
    scene.materials = [chosen[i % len(chosen)] for i in range(3)]
    scene.speed = max(math.sqrt(1.5 * m["young"] / m["density"])
                      for m in scene.case["materials"].values())  # fmt: skip


def memory(rng, scene):
    """The softest material remembers what it went through, see cases/softening.py."""
    for name in ("soft", "bar"):
        entry = scene.case["materials"].get(name)
        if entry:
            law = {"model": "softening", "damage": number(rng, 0.2, 0.9)}
            poisson = {"poisson": entry.get("poisson", 0.0)}
            entry.update(law | poisson | {"toughness": number(rng, 0.01, 3.0)})
            scene.states = ("damage", "peak-energy")


def metals(rng, scene):
    """Metals in place of materials that remember nothing: of all kinds, with all they may have."""
    plain = [name for name, entry in scene.case["materials"].items() if "damage" not in entry]
    for name in plain[: rng.kind.choice((1, 2, 3))]:
        entry = scene.case["materials"][name]
        E, rho = entry["young"], entry["density"]
        limit = E * 10.0 ** rng.uniform(-3.0, -1.0)
        entry.setdefault("poisson", 0.3)
        if rng.kind.random() < 0.5:
            entry |= {"model": "von-mises", "yield-stress": limit}
            entry["hardening"] = rng.choice((0.0, 0.02 * E))
            if rng.kind.random() < 0.5:
                entry["saturation"] = {"stress": 0.5 * limit, "rate": number(rng, 1.0, 50.0)}
            if rng.kind.random() < 0.5:
                entry["kinematic"] = 0.02 * E
            scene.states += ("plastic-strain",)
            continue
        entry |= {"model": "johnson-cook", "a": limit, "b": limit, "n": number(rng, 0.2, 0.8)}
        entry |= {"c": number(rng, 0.0, 0.1), "m": number(rng, 0.5, 1.5), "temperature": 300.0}
        entry |= {"melting": 1000.0, "specific-heat": 0.02 * limit / rho, "reference-rate": 0.1}
        if rng.kind.random() < 0.5:
            entry["damage"] = {"d1": number(rng, 0.01, 0.2), "d2": 0.1, "d3": -1.5, "d5": 0.3}
        if rng.kind.random() < 0.5:
            law = {"c0": math.sqrt(E / rho), "s": number(rng, 0.5, 1.5)}
            entry["eos"] = {"mie-gruneisen": law | {"gamma": number(rng, 0.0, 2.0)}}
        scene.states += ("plastic-strain", "temperature")
    scene.states = tuple(dict.fromkeys(scene.states))


def laws(rng, modulus, density):
    """Soils, fluids and gases whose waves are no faster than those of a solid of a modulus."""
    angle = number(rng, 5.0, 40.0)
    solid = {"young": modulus, "poisson": number(rng, 0.0, 0.3)}
    cohesion = rng.choice((0.0, number(rng, 0.001, 0.05) * modulus))
    strong = {"cohesion": cohesion, "friction-angle": angle}
    strong |= {"dilation-angle": rng.choice((0.0, 0.5, 1.0)) * angle}
    if cohesion and rng.random() < 0.4:
        strong["tension"] = rng.choice((0.0, 0.5)) * cohesion
    liquid = {"bulk": modulus, "exponent": rng.choice((1.0, 7.0, 2.5))}
    liquid["tension"] = rng.random() < 0.4
    viscosity = number(rng, 0.001, 0.02) * math.sqrt(modulus * density)
    return {
        "drucker-prager": solid | strong,
        "mohr-coulomb": solid | strong,
        "cam-clay": {
            "m": number(rng, 0.8, 1.4), "lambda": 0.2, "kappa": 0.05, "void-ratio": 1.0,
            "shear": 0.3 * modulus, "preconsolidation": 0.02 * modulus,
            "pressure": number(rng, 0.002, 0.02) * modulus,
        },
        "mu-i": solid | {
            "mu-s": 0.38, "mu-2": number(rng, 0.4, 1.0), "i0": 0.279, "grain": 0.01,
            "grain-density": 2.0 * density,
        },
        "newtonian": liquid | {"shear-viscosity": viscosity},
        "bingham": liquid | {
            "bulk": 0.6 * modulus, "shear-viscosity": viscosity,
            "yield-stress": number(rng, 0.001, 0.02) * modulus,
        },
        "ideal-gas": {
            "gamma": number(rng, 1.1, 1.7), "energy": number(rng, 0.005, 0.03) * modulus / density,
        },
    }  # fmt: skip


def flows(rng, scene):
    """Some materials are soils, fluids or gases."""
    from pgimp.physics.materials import MATERIALS as KNOWN

    chosen = [*scene.case["materials"]]
    for name in rng.kind.sample(chosen, rng.kind.randint(1, len(chosen))):
        entry = scene.case["materials"][name]
        if entry["model"] == "softening":
            continue
        density, of = entry["density"], laws(rng, entry["young"], entry["density"])
        model = rng.kind.choice([*of])
        scene.case["materials"][name] = {"model": model, "density": density} | of[model]
    states = []
    for entry in scene.case["materials"].values():
        law = KNOWN.get(entry["model"])
        known = law.model_validate(entry).states if law else ()
        states += [state.name for state in known if not state.tensor]
        states += ["damage", "peak-energy"] if law is None else []
    scene.states = tuple(dict.fromkeys(states))


def runs(scene, body):
    """Whether of a body's deformation only the volume is followed."""
    from pgimp.physics.materials import MATERIALS as KNOWN

    name = scene.case["bodies"][body]["material"]
    entry = KNOWN.get(scene.case["materials"][name]["model"])
    return entry is not None and entry.VOLUME_ONLY


def affine(rng, scene):
    """Particles carry their velocity gradient."""
    scene.case["method"]["affine"] = True


def mean(rng, scene):
    """Cells have one rate of dilatation each; where particles are boxes."""
    if scene.case["method"]["shape"] in ("gimp", "finite-gimp", "cpdi"):
        scene.case["method"]["volumetric"] = "mean"


def relaxation(rng, scene):
    """Particles' velocities relax towards the grid's."""
    scene.case["method"]["relaxation"] = number(rng, 0.5, 20.0)


def viscosity(rng, scene):
    """Artificial viscosity in every material, perhaps of one kind."""
    for entry in scene.case["materials"].values():
        terms = {"linear": number(rng, 0.0, 0.3), "quadratic": number(rng, 0.0, 1.5)}
        entry["viscosity"] = terms


def table(rng, scene, most, size=None):
    """A load or velocity over the time of the run, linear in between."""
    times = sorted({round(rng.uniform(-0.2, 1.2) * scene.end, 5) for _ in range(rng.randint(1, 4))})
    value = (lambda: number(rng, -most, most)) if size is None else lambda: vector(rng, size, most)
    return {"table": [[time, value()] for time in times]}


def time(rng, scene):
    """Fixed steps, or Courant control; 20 to 60 of them."""
    steps, courant = rng.randint(20, 60), number(rng, 0.08, 0.35)
    step = float(f"{courant * min(scene.cell) / (1.2 * scene.speed):.3g}")
    scene.steps, scene.end = steps, round(steps * step, 12)
    scene.case["time"] = {"end": scene.end, "step": step}
    if rng.random() < 0.35:
        scene.case["time"]["step"] = {"courant": courant}


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


def variation(rng, scene, value, column=None):
    """What a number may be that varies in space: by a third of it at most."""
    low, size = scene.case["grid"]["origin"], scene.case["grid"]["size"]
    kind = rng.choice(("table", "layers", "random", "random", "product"))
    if column is not None and rng.random() < 0.6:
        return {"column": column}
    if kind == "random":
        lengths = [number(rng, 0.5, 6.0) * h for h in scene.cell]
        field = {
            "mean": value, "cov": number(rng, 0.0, 0.3), "seed": rng.randint(0, 99), "modes": 40,
            "correlation": lengths if rng.random() < 0.5 else min(lengths),
            "covariance": rng.choice(("exponential", "gaussian")),
            "distribution": rng.choice(("normal", "lognormal")),
        }  # fmt: skip
        return {"random": field, "between": [0.7 * value, 1.4 * value]}
    d = rng.randrange(scene.dimension)
    over = {"over": "xyz"[d]}
    begin, end = low[d] - 1.0, low[d] + size[d] + 1.0
    if d == scene.dimension - 1 and rng.random() < 0.5:
        over = {"over": "depth", "surface": low[d] + size[d]}
        begin, end = -1.0, size[d] + 1.0
    places = sorted({round(rng.uniform(begin, end), 3) for _ in range(rng.randint(0, 3))})
    rows = [[place, number(rng, 0.75, 1.3) * value] for place in (begin, *places, end)]
    if kind == "product":
        return over | {"table": [[t, v / value] for t, v in rows], "times": value}
    return over | {kind: rows}


def varied(rng, scene):
    """Numbers of materials vary in space; some are columns of particles of a file."""
    for name, entry in scene.case["materials"].items():
        keys = [key for key in VARY if isinstance(entry.get(key), float) and entry[key]]
        bodies = [body for body in scene.case["bodies"].values() if body.get("material") == name]
        files = [body["region"].get("points", {}).get("file") for body in bodies]
        for key in rng.kind.sample(keys, min(len(keys), rng.kind.randint(0, 3))):
            column = f"own-{key}" if files and all(files) else None
            # A share of the strength that is lost, below one wherever it varies.
            value = min(entry[key], 0.7) if key == "damage" else entry[key]
            entry[key] = variation(rng, scene, value, column)
            scene.states += (f"parameter-{key}",)
            if entry[key] == {"column": column}:
                for file in set(files):
                    head, *rows = scene.files[file].rstrip("\n").split("\n")
                    rows = [f"{row},{number(rng, 0.75, 1.3) * value!r}" for row in rows]
                    scene.files[file] = "\n".join([f"{head},{column}", *rows]) + "\n"
    scene.states = tuple(dict.fromkeys(scene.states))


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
    """Separating walls have friction."""
    for face, kind in scene.case["boundaries"].items():
        if kind == "separating":
            most = number(rng, 0.05, 1.0)
            friction = most if rng.random() < 0.6 else {"static": most, "kinetic": 0.5 * most}
            scene.case["boundaries"][face] = {"separating": {"friction": friction}}


def escape(rng, scene):
    """Most faces that are open let particles out; one that does not may end the run."""
    open_faces = [face for face in scene.faces if face not in scene.case["boundaries"]]
    ways = {face: "remove" if rng.random() < 0.97 else "stop" for face in open_faces}
    scene.case["escape"] = ways


def gravity(rng, scene):
    """Constant, or over time."""
    most = 0.05 * scene.speed**2 / max(scene.cells)
    value = vector(rng, scene.dimension, most)
    scene.case["gravity"] = value if rng.random() < 0.6 else table(
        rng, scene, most, scene.dimension
    )  # fmt: skip


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
    if rng.random() < 0.5:
        entry["pressure"] = table(rng, scene, 5.0) if rng.random() < 0.4 else number(rng, -5, 5)
    else:
        varies = rng.random() < 0.4
        entry["traction"] = (
            table(rng, scene, 5.0, scene.dimension) if varies else vector(rng, scene.dimension, 5.0)
        )
    scene.case["tractions"] = {"load": entry}


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
    grips = scene.case.setdefault("constraints", {})
    grips[f"grip{len(grips)}"] = entry


def tools(rng, scene):
    """One or two rigid bodies, beside a body, that stand, move or turn."""
    D, h = scene.dimension, scene.cell
    for number_of in range(rng.choice((1, 1, 2))):
        low, high = (list(corner) for corner in scene.corners[rng.choice([*scene.corners])])
        d, side = rng.randrange(D), rng.choice((-1, 1))
        size = [b - a + number(rng, 0.0, 2.0) * c for a, b, c in zip(low, high, h, strict=True)]
        size[d] = number(rng, 1.2, 3.0) * h[d]
        gap = number(rng, 0.0, 1.5) * h[d] if rng.random() < 0.7 else 0.0
        first = [a + number(rng, -1.0, 1.0) * c for a, c in zip(low, h, strict=True)]
        first[d] = high[d] + gap if side > 0 else low[d] - gap - size[d]
        last = [a + b for a, b in zip(first, size, strict=True)]
        kind = rng.random()
        made = box if kind < 0.5 else (ball if kind < 0.75 else union)
        motion, most = {}, 0.15 * scene.speed
        if rng.random() < 0.7:
            velocity = vector(rng, D, most)
            velocity[d] = -side * number(rng, 0.0, most)
            motion["velocity"] = velocity if rng.random() < 0.6 else table(rng, scene, most, D)
        if D > 1 and rng.random() < 0.4:
            rate = most / max(size)
            turns = number(rng, -rate, rate) if rng.random() < 0.6 else table(rng, scene, rate)
            motion["rotation"] = {"about": middle(first, last), "rate": turns}
            if D == 3:
                motion["rotation"]["axis"] = [1.0, *vector(rng, 2, 1.0)]
        region = made(rng, first, last, scene)
        scene.case["bodies"][f"tool{number_of}"] = {"rigid": motion, "region": region}


def free(rng, scene):
    """A rigid body that moves freely towards a body beside it: lighter, heavier, or alike."""
    D, h, grid = scene.dimension, scene.cell, scene.case["grid"]
    for _ in range(20):  # as walls are not felt, within the domain
        low, high = rng.choice([*scene.corners.values()])
        d, side = rng.randrange(D), rng.choice((-1, 1))
        size = [number(rng, 1.5, 4.0) * c for c in h]
        first = [number(rng, a - 0.5 * s, b - 0.5 * s)
                 for a, b, s in zip(low, high, size, strict=True)]  # fmt: skip
        gap = number(rng, 0.0, 1.0) * h[d]
        first[d] = high[d] + gap if side > 0 else low[d] - gap - size[d]
        last = [a + b for a, b in zip(first, size, strict=True)]
        corner = [a + b for a, b in zip(grid["origin"], grid["size"], strict=True)]
        if all(a >= b for a, b in zip([*first, *corner], [*grid["origin"], *last], strict=True)):
            break
    velocity = vector(rng, D, 0.1 * scene.speed)
    velocity[d] = -side * number(rng, 0.0, 0.15 * scene.speed)
    free = {"density": 10.0 ** number(rng, -3.0, 2.0)}
    if rng.random() < 0.3:
        free["fixed"] = [rng.choice(("rotation", "x") if D > 1 else ("x",))]
        velocity[0] *= free["fixed"] != ["x"]
    entry = {"rigid": free, "region": rng.choice((box, ball, union))(rng, first, last, scene)}
    entry["velocity"] = velocity
    if D > 1 and not free.get("fixed") and rng.random() < 0.4:
        turns = vector(rng, 3, 0.1 * scene.speed / max(size))
        rotation = {"about": middle(first, last), "rate": turns if D == 3 else turns[2]}
        entry["velocity"] = {"rotation": rotation, "translation": velocity}
    scene.case["bodies"]["flies"] = entry


def contact(rng, scene):
    """A law for all pairs of bodies, or for some; with two bodies or more."""
    names = [*scene.case["bodies"]]
    if len(names) < 2:
        return

    def entry(bodies):
        law = rng.choice(("friction", "friction", "friction", "tied", "ignore"))
        found = {"bodies": bodies, "law": law}
        if law == "friction" and rng.random() < 0.7:
            most = number(rng, 0.0, 1.0)
            kinetic = number(rng, 0.0, 0.9) * most
            found["friction"] = most if rng.random() < 0.5 else {
                "static": most, "kinetic": kinetic
            }  # fmt: skip
        if law == "friction" and rng.random() < 0.25:
            strength = 10.0 ** number(rng, -2.0, 1.0)
            found["adhesion"] = {
                rng.choice(("normal", "shear")): strength,
                "reach": number(rng, 0.05, 0.9) * min(scene.case["grid"]["cell"]),
            }
            if rng.random() < 0.5:
                found["adhesion"] |= {"normal": strength, "shear": 0.5 * strength}
        return found

    entries = [entry("all")] if rng.random() < 0.7 else []
    if not entries or rng.random() < 0.4:
        entries.append(entry(rng.sample(names, rng.randint(2, len(names)))))
    scene.case["contact"] = entries


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
    case.pop("escape", None)
    default = [{"bodies": "all", "friction": 0.3}] if meets and "contact" in case else []
    laws = [
        entry for entry in case.pop("contact", [])
        if entry["bodies"] == "all" or all(name in case["bodies"] for name in entry["bodies"])
    ] or default  # fmt: skip
    if laws and len(case["bodies"]) > 1:
        case["contact"] = laws
    for part in ("volume", "volumetric"):
        case["method"].pop(part, None)
    for face, kind in case["boundaries"].items():
        if not meets and (kind == "separating" or "separating" in kind):
            case["boundaries"][face] = "slip"


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
    Feature("mirrors", mirrors, 0.4, compiled=True),
    Feature("affine", affine, 0.35, compiled=True),
    Feature("mean dilatation", mean, 0.35, compiled=True),
    Feature("relaxation", relaxation, 0.15, compiled=True),
    Feature("materials", materials),
    Feature("memory", memory, 0.2, compiled=True),
    Feature("metals", metals, 0.2, compiled=True),
    Feature("flows", flows, 0.35, compiled=True),
    Feature("viscosity", viscosity, 0.2, compiled=True),
    Feature("time", time),
    Feature("steps chosen", courant, 0.12, compiled=True),
    Feature("bodies", add_bodies),
    Feature("walls", walls, 0.7, compiled=True),
    Feature("rough walls", rough, 0.3, compiled=True),
    Feature("escape", escape, 0.95),
    Feature("gravity", gravity, 0.5),
    Feature("traction", traction, 0.25, compiled=True),
    Feature("constraint", constraint, 0.25, compiled=True),
    Feature("second constraint", constraint, 0.05, compiled=True),
    Feature("rigid bodies", tools, 0.3, compiled=True),
    Feature("free body", free, 0.12, compiled=True),
    Feature("contact", contact, 0.35, compiled=True),
    Feature("initial configuration", initial, 0.2, compiled=True),
    Feature("variation", varied, 0.25, compiled=True),
    Feature("stages", stages, 0.25),
    Feature("frames", frames),
    Feature("grid frames", grid_frames, 0.4),
    Feature("precision and compression", small_files, 0.4),
    Feature("history", history),
    Feature("probes", probes, 0.5),
    Feature("checkpoints", checkpoints),
)


def make(seed, number, group):
    """A random scene.

    Parameters
    ----------
    seed, number, group : int
        Of the proof, the scene, and those that share what is compiled.

    Returns
    -------
    case : dict
        As in a case file, with the title of the scene.
    files : dict of str to str
        The files that it names.
    features : list of str
        Names of the features that it has.
    """
    scene, names = Scene(), []
    for feature in FEATURES:
        rng = Chance(seed, number, group, feature.name)
        chance = rng.kind if feature.compiled else rng
        if feature.share == 1.0 or chance.random() < feature.share:
            feature.add(rng, scene)
            names.append(feature.name)
    title = f"scene {number} of group {group}, seed {seed}"
    return {"title": title, **scene.case}, scene.files, names
