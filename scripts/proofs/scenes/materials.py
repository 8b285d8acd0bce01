"""Features of random scenes that say what bodies are made of; see `scene_features`."""

import math

from proofs.scenes.bodies import number
from proofs.scenes.stages import VARY

MATERIALS = {
    "soft": {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0},
    "stiff": {"model": "hooke", "young": 300.0, "poisson": 0.25, "density": 2.0},
    "bar": {"model": "linear-1d", "young": 100.0, "density": 1.0},
    "heavy": {"model": "neo-hookean", "young": 80.0, "poisson": 0.0, "density": 3.0},
}


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


def viscosity(rng, scene):
    """Artificial viscosity in every material, perhaps of one kind."""
    for entry in scene.case["materials"].values():
        terms = {"linear": number(rng, 0.0, 0.3), "quadratic": number(rng, 0.0, 1.5)}
        entry["viscosity"] = terms


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
