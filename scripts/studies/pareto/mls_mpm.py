"""A worker that runs bodies with Taichi: MLS-MPM with APIC and quadratic B-splines.

As a user would write it after Taichi's examples, on one core: neo-Hookean, explicit, scattered with
atomic additions, all of a step in one kernel; a mass and a volume for each particle. Bodies on one
grid stick together. Run by `peer_runs`, in an environment that has Taichi; reads and writes files.

    python mls_mpm.py FOLDER f64|f32
"""

import json
import sys
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np
import taichi as ti

#: Empty cells past the domain's low faces, so that B-splines there have all their vertices.
PAD = 3
ROUNDS, SHORT = 3, 0.3


def stepper(real, start, cell, dt, lame, vertices, walls, vortex):
    """Positions and velocities of a body, what begins it, and its step.

    Particles start with X, v, L, m, V; walls are low faces' directions, and whether they let go,
    else they hold. The generalised vortex, if any, has amplitude, angular frequency, mean radius,
    width and mu/rho.
    """
    n, D = start["X"].shape
    inverse, (first, shear) = 1.0 / cell, lame
    X, x, v = (ti.Vector.field(D, real, n) for _ in range(3))
    C, F = (ti.Matrix.field(D, D, real, n) for _ in range(2))
    m, V = (ti.field(real, n) for _ in range(2))
    grid_m, grid_v = ti.field(real, vertices), ti.Vector.field(D, real, vertices)
    forced = vortex is not None
    a, w, mean, width, stiffness = vortex or [0.0] * 5
    centre = tuple(PAD * cell + start["centre"])

    def begin():
        for field, name in ((X, "X"), (x, "X"), (v, "v"), (C, "L"), (m, "m"), (V, "V")):
            field.from_numpy(start[name].astype(np.float64 if real == ti.f64 else np.float32))
        F.from_numpy(np.tile(np.eye(D), (n, 1, 1)))

    @ti.func
    def force(p, t):
        """Body force per mass of the vortex on the particle."""
        Z = X[p] - ti.Vector(centre)
        R = Z.norm()
        s = (R - mean) / width
        q = 1.0 - 4.0 * s * s
        h, slope = q * q, -16.0 * s * q / width
        bend = 16.0 * (12.0 * s * s - 1.0) / (width * width)
        g = a * ti.sin(w * t)
        cosine, sine = ti.cos(g * h), ti.sin(g * h)
        c, s1 = (cosine * Z[0] - sine * Z[1]) / R, (sine * Z[0] + cosine * Z[1]) / R
        rate = a * w * ti.cos(w * t) * h
        radial = R * (stiffness * g * g * slope * slope - rate * rate)
        hoop = -R * w * w * g * h - stiffness * g * (R * bend + 3.0 * slope)
        return ti.Vector([radial * c - hoop * s1, radial * s1 + hoop * c])

    @ti.kernel
    def step(t: real):
        for i in ti.grouped(grid_m):
            grid_m[i] = 0.0
            grid_v[i] = ti.Vector.zero(real, D)
        for p in x:
            base = (x[p] * inverse - 0.5).cast(int)
            f = x[p] * inverse - base.cast(real)
            weights = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]
            one = ti.Matrix.identity(real, D)
            F[p] = (one + dt * C[p]) @ F[p]
            kirchhoff = shear * (F[p] @ F[p].transpose() - one)
            kirchhoff += first * ti.log(F[p].determinant()) * one
            affine = -dt * V[p] * 4.0 * inverse * inverse * kirchhoff + m[p] * C[p]
            u = v[p]
            if ti.static(forced):
                u += dt * force(p, t)
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * D)))):
                distance = (offset.cast(real) - f) * cell
                weight = ti.cast(1.0, real)
                for d in ti.static(range(D)):
                    weight *= weights[offset[d]][d]
                grid_v[base + offset] += weight * (m[p] * u + affine @ distance)
                grid_m[base + offset] += weight * m[p]
        for i in ti.grouped(grid_m):
            if grid_m[i] > 0.0:
                grid_v[i] /= grid_m[i]
                for d, unilateral_walls in ti.static(walls):
                    if i[d] <= PAD:
                        if ti.static(unilateral_walls):
                            grid_v[i][d] = ti.max(grid_v[i][d], 0.0)
                        else:
                            grid_v[i] = ti.Vector.zero(real, D)
        for p in x:
            base = (x[p] * inverse - 0.5).cast(int)
            f = x[p] * inverse - base.cast(real)
            weights = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]
            u = ti.Vector.zero(real, D)
            B = ti.Matrix.zero(real, D, D)
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * D)))):
                weight = ti.cast(1.0, real)
                for d in ti.static(range(D)):
                    weight *= weights[offset[d]][d]
                vertex = grid_v[base + offset]
                u += weight * vertex
                B += weight * vertex.outer_product(offset.cast(real) - f)
            v[p], C[p] = u, 4.0 * inverse * B
            x[p] += dt * u

    return x, v, begin, step


def run(folder, job, real):
    """Run a job, short ones thrice; the median of CPU seconds. Its particles go to a file."""
    with np.load(folder / f"{job['name']}.npz") as file:
        start = dict(file)
    start["X"] = start["X"] + PAD * job["cell"]
    steps, seconds = job["steps"], []
    dt = job["end"] / steps
    words = [job[key] for key in ("lame", "vertices", "walls", "vortex")]
    x, v, begin, step = stepper(real, start, job["cell"], dt, *words)
    begin()
    step(0.0)  # compiles
    while not seconds or (len(seconds) < ROUNDS and seconds[0] < SHORT):
        begin()
        ti.sync()
        began = process_time()
        for k in range(steps):
            step(k * dt)
        ti.sync()
        seconds.append(process_time() - began)
    found = {"x": x.to_numpy().astype(float) - PAD * job["cell"], "v": v.to_numpy().astype(float)}
    np.savez(folder / f"{job['name']}-out.npz", **found)
    return {"seconds": median(seconds), "steps": steps, "particles": len(start["X"])}


def main(folder, precision):
    """Run the jobs of FOLDER/jobs.json; the answers go to answers.json beside it."""
    real = {"f64": ti.f64, "f32": ti.f32}[precision]
    answers = {}
    for job in json.loads((folder / "jobs.json").read_text()):
        ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=1, log_level=ti.ERROR)
        answers[job["name"]] = run(folder, job, real)
    version = ".".join(map(str, ti.__version__))
    (folder / "answers.json").write_text(json.dumps({"version": version, "runs": answers}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
