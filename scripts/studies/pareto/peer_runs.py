"""The same problems with Taichi's MLS-MPM, from the particles that pgimp makes."""

import json
import subprocess
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from studies.pareto.candidates import Method
from studies.pareto.fronts_drawn import PEER
from studies.pareto.ladders import joined

COURANT = 0.3
#: By dimension; in 3D runs are long, and float32 shows in 2D what it does.
PRECISIONS = {2: ("f64", "f32"), 3: ("f64",)}
#: As the worker's.
PAD = 3


def _job(folder, problem, n):
    """Write the particles of a problem, and return what the worker needs besides.

    They are at pgimp's places, with pgimp's masses: at a surface those of what lies within it.
    """
    sim, X = problem.begin(Method("gimp", affine=True), n)
    p, rows, D = sim.particles, sim.live(), problem.D
    rows = rows[np.argsort(p.id[rows])]
    case, frame = sim.scene.case, sim.scene.domain.frame
    origin, h = np.array(frame.origin)[:D], frame.cell[0]
    arrays = {
        "X": X - origin, "v": p.v[rows], "L": p.L[rows].reshape(-1, D, D), "m": p.m[rows],
        "V": p.V0[rows], "centre": -origin,
    }  # fmt: skip
    name = f"{problem.name}-{n}-{problem.off}"
    np.savez(folder / f"{name}.npz", **arrays)
    material = next(iter(case.materials.values()))
    mu = material.young / (2.0 * (1.0 + material.poisson))
    first = 2.0 * mu * material.poisson / (1.0 - 2.0 * material.poisson)
    speed = np.sqrt((first + 2.0 * mu) / material.density)
    speed += np.sqrt((p.v[rows] ** 2).sum(axis=1)).max()
    end = case.time.end
    return {
        "name": name, "cell": h, "vertices": [c + 2 * PAD + 1 for c in frame.cells], "end": end,
        "steps": int(np.ceil(end * speed / (COURANT * h))), "lame": [first, mu],
        "walls": [["xyz".index(face[0]), kind == "unilateral"] for face, kind in problem.walls],
        "vortex": problem.vortex(mu / material.density),
    }  # fmt: skip


def peer_ladder(problem, python):
    """Records of a problem with the peer, by precision and size; its version."""
    records, version = [], ""
    with TemporaryDirectory() as made:
        folder, jobs = Path(made), []
        for n, problem.off in product(problem.sizes, problem.places):
            jobs.append((n, problem.off, _job(folder, problem, n)))
        (folder / "jobs.json").write_text(json.dumps([words for *_, words in jobs]))
        script = str(Path(__file__).with_name("mls_mpm.py"))
        for precision in PRECISIONS[problem.D]:
            subprocess.run([python, script, made, precision], check=True, stdout=subprocess.DEVNULL)
            answer = json.loads((folder / "answers.json").read_text())
            version, found = answer["version"], {}
            for n, problem.off, job in jobs:
                run = answer["runs"][job["name"]] | {"error": _error(folder, problem, n, job)}
                found.setdefault(n, {})[problem.off] = [run]
            label = PEER if precision == "f64" else f"{PEER}, float32"
            key = {"problem": problem.name, "method": label, "peer": True}
            records += [key | {"n": n} | joined(runs) for n, runs in found.items()]
    return records, version


def _error(folder, problem, n, job):
    """Error of a run of the peer; None if it has blown up."""
    with np.load(folder / f"{job['name']}.npz") as start:
        X, m, origin = start["X"] - start["centre"], start["m"], -start["centre"]
    with np.load(folder / f"{job['name']}-out.npz") as end:
        x, v = end["x"] + origin, end["v"]
    return problem.error(n, X, x, v, m) if np.isfinite(x).all() else None
