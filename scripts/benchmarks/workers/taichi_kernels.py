"""The free block in Taichi, as a user would write it after Taichi's own examples, in float64.

Two methods: `gimp`, contiguous GIMP with the stress updated last, what pgimp computes; and
`mls-mpm`, MLS-MPM with APIC and quadratic B-splines, what most of Taichi's examples compute. Both
are explicit and neo-Hookean, and scatter with atomic additions. Taichi is imported when it is used.

What does not make them faster: one record a vertex instead of a field for each quantity, sums
factored by direction. Taichi's block-local storage is for particles held in blocks of a sparse
grid, another data structure than its examples have.
"""

import numpy as np
from workers.clock import clock


def start(threads):
    """Import and start Taichi; returns its version."""
    import taichi as ti

    ti.init(
        arch=ti.cpu, default_fp=ti.f64, default_ip=ti.i32, cpu_max_num_threads=threads,
        log_level=ti.ERROR,
    )  # fmt: skip
    return ".".join(map(str, ti.__version__))


class Block:
    """A block of particles by ``gimp`` or ``mls-mpm``; gravity is along the last direction.

    Positions x and velocities v, (n, D), are in the order in which they are stored; the first of
    the grid's `vertices` is at 0.
    """

    def __init__(self, method, x, v, vertices, cell, dt, per_cell, density, gravity, lame):
        make = {"gimp": _gimp, "mls-mpm": _mls_mpm}[method]
        volume = (cell / per_cell) ** x.shape[1]
        given = (x.shape[1], len(x), tuple(vertices), cell, dt, volume, density, gravity, *lame)
        self.step, self.x, self.v, self.stress = make(*given, 0.5 / per_cell)
        self.x.from_numpy(x)
        self.v.from_numpy(v)
        self.count, self.dt, self.steps = len(x), dt, 0

    def advance(self, steps):
        """Do steps; returns the seconds that they took."""
        import taichi as ti

        ti.sync()
        began = clock()
        for _ in range(steps):
            self.step()
        ti.sync()
        self.steps += steps
        return clock() - began

    def errors(self, velocity, gravity, young):
        """Greatest error of velocity over the speed, greatest stress over Young's modulus."""
        v = np.array(velocity, float)
        v[-1] += gravity * self.dt * self.steps
        difference = np.abs(self.v.to_numpy() - v).max() / np.linalg.norm(v)
        return float(difference), float(np.abs(self.stress()).max() / young)


def _fields(ti, D, n, vertices):
    """Fields of particles and grid: x, v, F, grid mass, grid momentum."""
    x, v = (ti.Vector.field(D, ti.f64, n) for _ in range(2))
    F = ti.Matrix.field(D, D, ti.f64, n)
    F.from_numpy(np.tile(np.eye(D), (n, 1, 1)))
    return x, v, F, ti.field(ti.f64, vertices), ti.Vector.field(D, ti.f64, vertices)


def _gimp(D, n, vertices, cell, dt, volume, density, gravity, first, shear, half):
    import taichi as ti

    inverse, mass = 1.0 / cell, density * volume
    x, v, F, grid_m, grid_v = _fields(ti, D, n, vertices)
    grid_a = ti.Vector.field(D, ti.f64, vertices)
    sigma = ti.Matrix.field(D, D, ti.f64, n)

    @ti.func
    def weights(xp):
        """First vertex; weights and gradients of three vertices, a row each, by direction."""
        base = ti.floor(xp * inverse - half).cast(int)
        f = xp * inverse - base.cast(ti.f64)
        t = 1.0 + half - f
        u = ti.max(1.0 - half - f, 0.0)
        s = ti.max(f - 1.0 + half, 0.0)
        w0 = (t * t - u * u) * (0.25 / half)
        w2 = s * s * (0.25 / half)
        g0 = (u - t) * (0.5 / half * inverse)
        g2 = s * (0.5 / half * inverse)
        return base, ti.Matrix.rows([w0, 1.0 - w0 - w2, w2]), ti.Matrix.rows([g0, -g0 - g2, g2])

    @ti.func
    def product(w, g, offset):
        """Weight and gradient of a vertex."""
        weight = 1.0
        slope = ti.Vector.one(ti.f64, D)
        for d in ti.static(range(D)):
            weight *= w[offset[d], d]
            for e in ti.static(range(D)):
                slope[e] *= g[offset[d], d] if ti.static(d == e) else w[offset[d], d]
        return weight, slope

    @ti.kernel
    def step():
        for i in ti.grouped(grid_m):
            grid_m[i] = 0.0
            grid_v[i] = ti.Vector.zero(ti.f64, D)
            grid_a[i] = ti.Vector.zero(ti.f64, D)
        for p in x:
            base, w, g = weights(x[p])
            stress = -volume * F[p].determinant() * sigma[p]
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * D)))):
                weight, slope = product(w, g, offset)
                grid_m[base + offset] += weight * mass
                grid_v[base + offset] += weight * mass * v[p]
                grid_a[base + offset] += stress @ slope
        for i in ti.grouped(grid_m):
            if grid_m[i] > 0.0:
                a = grid_a[i] / grid_m[i]
                a[D - 1] += gravity
                grid_a[i] = a
                grid_v[i] = grid_v[i] / grid_m[i] + dt * a
        for p in x:
            base, w, g = weights(x[p])
            u = ti.Vector.zero(ti.f64, D)
            a = ti.Vector.zero(ti.f64, D)
            L = ti.Matrix.zero(ti.f64, D, D)
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * D)))):
                weight, slope = product(w, g, offset)
                vertex = grid_v[base + offset]
                u += weight * vertex
                a += weight * grid_a[base + offset]
                L += vertex.outer_product(slope)
            v[p] += dt * a
            x[p] += dt * u
            F[p] = (ti.Matrix.identity(ti.f64, D) + dt * L) @ F[p]
            J = F[p].determinant()
            b = F[p] @ F[p].transpose()
            one = ti.Matrix.identity(ti.f64, D)
            sigma[p] = (shear * (b - one) + first * ti.log(J) * one) / J

    return step, x, v, sigma.to_numpy


def _mls_mpm(D, n, vertices, cell, dt, volume, density, gravity, first, shear, half):
    import taichi as ti

    inverse, mass = 1.0 / cell, density * volume
    x, v, F, grid_m, grid_v = _fields(ti, D, n, vertices)
    C = ti.Matrix.field(D, D, ti.f64, n)

    @ti.func
    def weights(f):
        """Quadratic B-splines of three vertices by direction."""
        return [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]

    @ti.func
    def kirchhoff(p):
        """Stress times J."""
        one = ti.Matrix.identity(ti.f64, D)
        return shear * (F[p] @ F[p].transpose() - one) + first * ti.log(F[p].determinant()) * one

    @ti.kernel
    def step():
        for i in ti.grouped(grid_m):
            grid_m[i] = 0.0
            grid_v[i] = ti.Vector.zero(ti.f64, D)
        for p in x:
            base = (x[p] * inverse - 0.5).cast(int)
            f = x[p] * inverse - base.cast(ti.f64)
            w = weights(f)
            F[p] = (ti.Matrix.identity(ti.f64, D) + dt * C[p]) @ F[p]
            affine = -dt * volume * 4.0 * inverse * inverse * kirchhoff(p) + mass * C[p]
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * D)))):
                distance = (offset.cast(ti.f64) - f) * cell
                weight = 1.0
                for d in ti.static(range(D)):
                    weight *= w[offset[d]][d]
                grid_v[base + offset] += weight * (mass * v[p] + affine @ distance)
                grid_m[base + offset] += weight * mass
        for i in ti.grouped(grid_m):
            if grid_m[i] > 0.0:
                grid_v[i] /= grid_m[i]
                grid_v[i][D - 1] += dt * gravity
        for p in x:
            base = (x[p] * inverse - 0.5).cast(int)
            f = x[p] * inverse - base.cast(ti.f64)
            w = weights(f)
            u = ti.Vector.zero(ti.f64, D)
            B = ti.Matrix.zero(ti.f64, D, D)
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * D)))):
                distance = offset.cast(ti.f64) - f
                weight = 1.0
                for d in ti.static(range(D)):
                    weight *= w[offset[d]][d]
                vertex = grid_v[base + offset]
                u += weight * vertex
                B += weight * vertex.outer_product(distance)
            v[p], C[p] = u, 4.0 * inverse * B
            x[p] += dt * u

    def stress():
        deformation = F.to_numpy()
        J = np.linalg.det(deformation)[:, None, None]
        one = np.eye(D)
        b = deformation @ deformation.transpose(0, 2, 1)
        return (shear * (b - one) + first * np.log(J) * one) / J

    return step, x, v, stress
