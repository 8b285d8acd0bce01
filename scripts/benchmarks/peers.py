"""pgimp against Taichi's kernels and, where there is one, a prototype's, all by turns.

Same block, same particles, same precision and step, same number of cores; each after compilation.
"""

import re
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np
from blocks import DENSITY, GRAVITY, PAD, YOUNG, block, create, lame, start_velocity, step_of
from picture import plt, save
from report import ERRORS, markdown, number, origin, spread, write
from workers.processes import HERE, Worker, environment, launch
from workers.taichi_python import taichi_python

from pgimp.solver.simulation import RESORT

METHODS = ("gimp", "mls-mpm")


def prototype_speed(path):
    """Median of the million particle-steps/s that a run of the prototype prints."""
    done = subprocess.run([sys.executable, path.name], cwd=path.parent, env=environment(),
                          capture_output=True, text=True)  # fmt: skip
    found = re.search(r"median ([0-9.]+)", done.stdout)
    if done.returncode != 0 or not found:
        raise SystemExit(f"benchmark: {path} failed:\n{done.stderr[-2000:]}")
    return float(found[1])


def main(folder, quick, prototype=None):
    """Measure, and write peers.md, peers.csv and peers.png; returns rows by scene and code."""
    sizes = {2: (24, 24), 3: (6, 6, 6)} if quick else {2: (256, 256), 3: (32, 32, 32)}
    rounds, steps = (2, 4) if quick else (6, RESORT)
    python = None if quick else taichi_python()
    rows, makers, speeds_of_prototype, versions = [], [], [], {}
    with TemporaryDirectory() as made:
        workers = {("pgimp", n): Worker(launch(n, ["workers/pgimp_worker.py"])) for n in (1, 2)}
        if python:
            script = str(HERE / "workers" / "taichi_worker.py")
            for threads in (1, 2):
                workers["Taichi", threads] = Worker([python, script, str(threads)])
            versions["Taichi"] = workers["Taichi", 1].ask(do="version")["version"]
        try:
            for D, cells in sizes.items():
                file = str(Path(made) / f"{D}.npz")
                sim = create(block(cells), random=True)
                p, order = sim.particles, sim.live()
                np.savez(file, x=p.x[order], v=p.v[order])
                del sim, p
                scene = {
                    "vertices": [n + 2 * PAD + 1 for n in cells],
                    "cell": 1.0 / cells[-1], "dt": step_of(1.0 / cells[-1]), "per_cell": 2,
                    "density": DENSITY, "gravity": GRAVITY, "lame": lame(),
                }  # fmt: skip
                check = {"velocity": start_velocity(D), "gravity": GRAVITY, "young": YOUNG}
                for (code, cores), worker in workers.items():
                    kinds = METHODS if code == "Taichi" else ("random", "lattice")
                    for kind in kinds:
                        name = f"{D}D {kind}"
                        if code == "Taichi":  # shorter rounds of longer steps
                            words = {"method": kind, "file": file, "scene": scene}
                            words["steps"] = max(1, steps // 3)
                        else:
                            words = {"case": block(cells), "random": kind == "random"}
                            words["steps"] = steps
                        answer = worker.ask(do="make", name=name, **words)
                        key = {"dimension": D, "code": code, "kind": kind, "cores": cores}
                        makers.append((worker, name, check, key | answer))
            for _ in range(rounds):
                for worker, name, _, _ in makers:
                    worker.ask(do="round", name=name)
                if prototype:
                    speeds_of_prototype.append(prototype_speed(Path(prototype).resolve()))
            for worker, name, check, row in makers:
                words = {"scene": check} if row["code"] == "Taichi" else {}
                found = worker.ask(do="result", name=name, **words)
                found.pop("phases", None)
                rows.append(row | found)
        finally:
            for worker in workers.values():
                worker.close()
    if speeds_of_prototype:
        rows.append({
            "dimension": 3, "code": "prototype", "kind": "lattice", "cores": 1,
            "particles": 262_144, "speeds": speeds_of_prototype,
            "speed": median(speeds_of_prototype), "velocity": None, "stress": None,
        })  # fmt: skip
    rows.sort(key=lambda row: (-row["dimension"], row["cores"]))
    columns = {
        "scene": lambda row: f"{row['dimension']}D, {row['cores']} core" + "s" * (row["cores"] > 1),
        "code": lambda row: f"{row['code']}, {row['kind']}",
        "million particle-steps/s": lambda row: spread(row["speeds"]),
    } | ERRORS
    shares = ratios(rows)
    note = f"{markdown(RATIOS, shares)}\n\n" if shares else ""
    note += (
        f"Neo-Hookean block of {' and '.join(size(cells) for cells in sizes.values())} cells, 2 "
        "particles a cell and direction, in free fall, float64; whole steps, medians (least to "
        f"greatest) of {rounds} rounds by turns, of {steps} steps, Taichi's {max(1, steps // 3)}, "
        "after compilation. pgimp: contiguous GIMP, particles at random places or on a lattice; "
        "Taichi's are the same random ones, sorted by cell. Errors against the exact free fall, "
        "over speed and Young's modulus. "
        f"{origin(**versions)}"
    )
    write(folder, "peers", "pgimp and its peers", columns, rows, note)
    if not quick:
        draw(folder, rows)
    return rows


def size(cells):
    return " x ".join(map(str, cells))


#: The speed of one over that of another, of the same rounds, and what is to be reached in 3D.
TARGETS = (
    ("random", "prototype", "lattice", 1.0), ("lattice", "prototype", "lattice", 1.4),
    ("random", "Taichi", "gimp", 6.0), ("random", "Taichi", "mls-mpm", 4.0),
)  # fmt: skip
RATIOS = {
    "scene": lambda row: row["scene"],
    "speed of pgimp, over that of": lambda row: row["over"],
    "ratio": lambda row: number(row["ratio"], 2),
    "wanted": lambda row: number(row["wanted"]),
}


def ratios(rows):
    """Ratios to the peers, round by round, as far as they are there."""
    found = {(r["dimension"], r["cores"], r["code"], r["kind"]): r["speeds"] for r in rows}
    lines = []
    for D, cores in dict.fromkeys(key[:2] for key in found):
        for kind, code, other, wanted in TARGETS:
            mine, theirs = found.get((D, cores, "pgimp", kind)), found.get((D, cores, code, other))
            if mine and theirs:
                lines.append({
                    "scene": f"{D}D, {cores} core{'s' * (cores > 1)}, {kind}",
                    "over": f"{code}, {other}",
                    "ratio": median(a / b for a, b in zip(mine, theirs, strict=True)),
                    "wanted": wanted if D == 3 else None,
                })  # fmt: skip
    return lines


def draw(folder, rows):
    scenes = list(dict.fromkeys((row["dimension"], row["cores"]) for row in rows))
    figure, axes = plt.subplots(1, len(scenes), figsize=(2.9 * len(scenes), 3.2))
    for axis, scene in zip(np.atleast_1d(axes), scenes, strict=True):
        shown = [row for row in rows if (row["dimension"], row["cores"]) == scene]
        names = [f"{row['code']}\n{row['kind']}" for row in shown]
        speeds = [row["speed"] for row in shown]
        low = [row["speed"] - min(row["speeds"]) for row in shown]
        high = [max(row["speeds"]) - row["speed"] for row in shown]
        colours = ["#1f5fa8" if row["code"] == "pgimp" else "#8a8a8a" for row in shown]
        axis.bar(names, speeds, yerr=(low, high), color=colours, width=0.7)
        axis.set_title(f"{scene[0]}D, {scene[1]} core{'s' * (scene[1] > 1)}", fontsize=9)
        axis.tick_params(axis="x", labelsize=7, rotation=45)
    np.atleast_1d(axes)[0].set_ylabel("million particle-steps/s")
    save(figure, folder / "peers.png")
