"""The method in plain NumPy, from its equations: dense loops, nothing shared with the kernels.

Matrices are (3, 3) also in 1D and 2D (plane strain). Weights are in `reference_weights`.
"""

import numpy as np
from reference_materials import STRESS, matrix, speed, tensor, voigt
from reference_weights import ReferenceWeights

from pgimp.kernels.loads.wall_gap import CLOSED
from pgimp.kernels.update.mean_dilatation import DENSE, SPARSE


class Reference(ReferenceWeights):
    """The arrays on all vertices of a grid: m (vertices), p, f, v, a (vertices, D).

    With `mean`, cells have one rate of dilatation each.
    """

    def __init__(self, name, per_cell, frame, mean=False):
        super().__init__(name, per_cell, frame)
        self.mean = mean

    def alone(self, S, volume_of_mass):
        """Of a particle, from what the vertices around have of a full neighbourhood's mass."""
        fill = (S * self.m).sum() * volume_of_mass / np.prod(self.frame.cell)
        return np.interp(fill, [SPARSE**self.D, DENSE**self.D], [1.0, 0.0])

    def particles_to_grid(self, particles):
        """(16), (21), (22)."""
        self.m = np.zeros(self.shape)
        self.p = np.zeros((*self.shape, self.D))
        self.f = np.zeros((*self.shape, self.D))
        for k in range(len(particles.m)):
            S, grad = self.of(particles.x[k], particles.F[k])
            sigma = tensor(particles.sigma[k])[: self.D, : self.D]
            self.m += particles.m[k] * S
            self.p += particles.m[k] * S[..., None] * particles.v[k]
            if self.mean:
                mean = (1.0 - particles.isolation[k, 0]) * np.trace(sigma) / self.D
                rates = self.dilatation_of(particles.x[k], particles.F[k])
                self.f -= particles.V[k] * mean * rates
                sigma = sigma - mean * np.eye(self.D)
            self.f -= particles.V[k] * grad @ sigma
        self.particles = particles

    def moments(self, faces):
        """What tells how far bodies are from each face that lets go, (vertices).

        The distance z of a face along the wall, for which sum m (w . grad S + S div w) is
        -2 z/(h - z) of sum m S, on and beyond the wall. w is the distance from the wall up to 1.25
        cells, or a quarter of what is between two walls, and falls to zero at twice that.
        """
        near = [(axis, side) for kind, axis, side, _, _ in faces if kind == "unilateral"]
        frame = self.frame
        low = np.array(frame.origin)
        high = low + np.array(frame.cells) * frame.cell
        total = np.zeros(self.shape)
        for axis in {axis for axis, _ in near}:
            walls = [(low, high)[side > 0][axis] for d, side in near if d == axis]
            peak = frame.cell[axis] * min(1.25, frame.cells[axis] / 4 if len(walls) > 1 else 1.25)
            p = self.particles
            for x, F, m in zip(p.x, p.F, p.m, strict=True):
                z = x[axis] - min(walls, key=lambda wall: abs(x[axis] - wall))
                w = np.sign(z) * np.interp(abs(z), [0.0, peak, 2.0 * peak], [0.0, peak, 0.0])
                slope = float(abs(z) < peak) - float(peak <= abs(z) < 2.0 * peak)
                S, grad = self.of(x, F)
                total += m * (w * grad[..., axis] + slope * S)
        return total

    def clearances(self, faces, total):
        """How far bodies are from each face that lets go, (vertices), by its axis and side."""
        frame, found = self.frame, {}
        for kind, axis, side, _, _ in faces:
            if kind != "unilateral":
                continue
            face = frame.ghost + (frame.cells[axis] if side > 0 else 0)
            m, lack = (np.take(field, [face], axis) for field in (self.m, -total))
            lack = np.maximum(lack, 0.0)
            way = np.where(m > 0, lack / np.where(m > 0, 2 * m + lack, 1.0), 0.0)
            way = np.maximum(way - CLOSED, 0.0)
            found[axis, side] = np.broadcast_to(frame.cell[axis] * way, self.shape)
        return found

    def update_momentum(self, dt, gravity, faces, mass_cutoff, mirrors=()):
        """(14) with (17), then the conditions of `faces`: (kind, axis, side, velocity, rate).

        Sets the impulse of each face, (faces, D), and the work of gravity and faces; with
        `mirrors`, see `fold`, both are only those of the vertices that are left.
        """
        gone, total = np.zeros(self.shape, bool), self.moments(faces)
        force = self.f + self.m[..., None] * np.asarray(gravity[: self.D], float)  # (14)
        folded = []
        for releases in (False, True):
            if releases:
                near = self.clearances(faces, total)
                closing = {face: way / dt for face, way in near.items()}
            for mirror in mirrors:
                if mirror[2] == releases:
                    most = closing[mirror[:2]] if releases else None
                    folded.append(self.fold(force, dt, gone, total, most, *mirror))
        heavy = self.m > mass_cutoff
        m = np.where(heavy, self.m, 1.0)[..., None]
        b = np.asarray(gravity[: self.D], float)
        self.a = np.where(heavy[..., None], force / m, 0.0)
        light = np.where((self.m > 0) & ~heavy, self.m, 1.0)[..., None]
        self.v = np.where(heavy[..., None], self.p / m + self.a * dt, self.p / light)
        m = self.m[..., None]
        free, self.impulse = self.a.copy(), []
        for kind, axis, side, velocity, rate in faces:
            x = self.vertices[axis]
            L = self.frame.cell[axis]
            wall = self.frame.origin[axis] + (side > 0) * self.frame.cells[axis] * L
            at = (x - wall) * side > -1e-9 * L
            behind = np.broadcast_to(
                at.reshape([-1 if d == axis else 1 for d in range(self.D)]), self.shape
            )
            behind = behind & (self.m > 0)
            before = self.v.copy(), self.a.copy()
            if kind == "unilateral":  # first what particles bring, then that after forces
                most = closing[axis, side]
                brought = side * (self.v - dt * self.a)[..., axis]
                late = np.minimum(brought, most) + side * dt * self.a[..., axis]
                last = np.minimum(late, most)
                self.v[behind, axis] = side * last[behind]
                self.a[behind, axis] += side * (last - late)[behind] / dt
            for d in range(self.D):
                where = behind.copy()
                v, a = 0.0, 0.0
                if kind == "slip":
                    where &= d == axis
                elif kind == "unilateral":
                    where[:] = False
                elif kind == "velocity":
                    where &= velocity[d] is not None
                    v, a = velocity[d], rate[d]
                else:
                    assert kind == "fixed"
                self.v[where, d] = v
                self.a[where, d] = a
            gained = m * self.gains(*before, dt)
            self.impulse.append(gained.reshape(-1, self.D).sum(axis=0))
        # Where faces meet, the velocity that counts is the one that all of them leave.
        self.work = dt * (m * (b + self.a - free) * self.v).sum()
        for (axis, side, _, sticks), every in zip(mirrors[::-1], folded[::-1], strict=True):
            sign = np.where((np.arange(self.D) == axis) | sticks, -1.0, 1.0)
            for (beyond, image), taken in zip(self.images(axis, side), every, strict=True):
                for field in (self.v, self.a):
                    rows = np.moveaxis(field, axis, 0)
                    rows[beyond][taken] = sign * rows[image][taken]

    def gains(self, v, a, dt):
        """Velocity that particles gain by conditions, before which the vertices had v and a."""
        return dt * (self.a - a)

    def images(self, axis, side):
        """Vertex numbers along `axis` beyond a face, and their mirror images'."""
        ghost, cells = self.frame.ghost, self.frame.cells[axis]
        wall = ghost if side < 0 else ghost + cells
        pairs = [(wall + side * k, wall - side * k) for k in range(1, ghost + 1)]
        return [(g, r) for g, r in pairs if 0 <= r < self.shape[axis]]

    def fold(self, force, dt, gone, total, closing, axis, side, releases, sticks):
        """Add what is beyond a face to the mirror images, but not where the face lets go.

        `gone` becomes true for vertices that have given away what they had: at edges, where faces
        meet that may let go, those take no more.

        Returns
        -------
        list of (vertices of the other directions) bool
            What was folded, for each pair of `images`.
        """
        wall = self.frame.ghost + (side > 0) * self.frame.cells[axis]
        m, p, f = (np.moveaxis(field, axis, 0) for field in (self.m, self.p, force))
        into = p[wall][..., axis] + dt * f[wall][..., axis]
        taken = np.ones(m[wall].shape, bool)
        if releases:
            most = np.moveaxis(closing, axis, 0)[wall]
            taken = into * side > most * m[wall]
        sign = np.where((np.arange(self.D) == axis) | sticks, -1.0, 1.0)
        lost, folded, near = np.moveaxis(gone, axis, 0), [], np.moveaxis(total, axis, 0)
        for beyond, image in self.images(axis, side):
            where = taken & (m[beyond] > 0) & ~lost[image]
            near[image] += np.where(where, near[beyond], 0.0)
            m[image] += np.where(where, m[beyond], 0.0)
            m[beyond] = np.where(where, 0.0, m[beyond])
            for field in (p, f):
                field[image] += np.where(where[..., None], sign * field[beyond], 0.0)
                field[beyond] = np.where(where[..., None], 0.0, field[beyond])
            lost[beyond] |= where
            folded.append(where)
        return folded

    def grid_to_particles(self, particles, materials, material_of, dt, tracked):
        """(26), (27), (29), (30), volume and stress; and the largest (c + |v|)/L.

        Also counts the particles whose half-width is clamped by then.
        """
        self.rate, self.clamped = 0.0, 0
        for k in range(len(particles.m)):
            S, grad = self.of(particles.x[k], particles.F[k])
            L = np.zeros((3, 3))
            for r in range(self.D):
                for c in range(self.D):
                    L[r, c] = (self.v[..., r] * grad[..., c]).sum()
            if self.mean:
                rate = (self.v * self.dilatation_of(particles.x[k], particles.F[k])).sum()
                part = (1.0 - particles.isolation[k, 0]) / self.D
                L[: self.D, : self.D] += part * (rate - np.trace(L)) * np.eye(self.D)
                particles.isolation[k] = self.alone(S, particles.V[k] / particles.m[k])
            particles.x[k] += dt * np.tensordot(S, self.v, self.D)
            particles.v[k] += dt * np.tensordot(S, self.a, self.D)
            F = (np.eye(3) + dt * L) @ matrix(particles.F[k])
            particles.F[k] = F[: self.D, : self.D].reshape(-1)
            self.clamped += self.half_widths(particles.F[k])[1]
            J = np.linalg.det(F)
            if tracked:
                particles.V[k] = J * particles.V0[k]
            material = materials[material_of[particles.body[k]]]
            law = STRESS[type(material).__name__]
            sigma = law(material, F, tensor(particles.sigma[k]), dt * L)
            particles.sigma[k] = voigt(sigma, particles.sigma.shape[1])
            c = speed(material, F, self.D)
            fast = (c + np.linalg.norm(particles.v[k])) / min(self.frame.cell)
            self.rate = max(self.rate, fast)
