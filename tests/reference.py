"""The method in plain NumPy, from its equations: dense loops, nothing shared with the kernels.

All vertices of the grid count, those beyond the faces too; a particle's weights of all of them are
arrays that are zero outside the support. Matrices are (3, 3) also in 1D and 2D (plane strain).
"""

import numpy as np


def matrix(F):
    """(3, 3) deformation gradient from the D*D entries of a row; 1 in the other directions."""
    D = round(len(F) ** 0.5)
    full = np.eye(3)
    full[:D, :D] = np.reshape(F, (D, D))
    return full


def tensor(sigma):
    """(3, 3) stress from xx yy zz [xy [yz xz]]."""
    xx, yy, zz, xy, yz, xz = np.concatenate([sigma, np.zeros(6 - len(sigma))])
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def voigt(T, n):
    """The first `n` of xx yy zz xy yz xz of a (3, 3) tensor."""
    return np.array([T[0, 0], T[1, 1], T[2, 2], T[0, 1], T[1, 2], T[0, 2]][:n])


def neo_hookean(material, F, sigma, dL):
    """s = mu/J (b - 1) + lambda ln J / J 1."""
    J = np.linalg.det(F)
    return (material.mu * (F @ F.T - np.eye(3)) + material.lam * np.log(J) * np.eye(3)) / J


def hooke(material, F, sigma, dL):
    """Hughes-Winget with the gradient of the step's displacement about the mid-point."""
    G = dL @ np.linalg.inv(np.eye(3) + 0.5 * dL)
    W, D = (G - G.T) / 2, (G + G.T) / 2
    Q = np.linalg.solve(np.eye(3) - 0.5 * W, np.eye(3) + 0.5 * W)
    return Q @ sigma @ Q.T + material.lam * np.trace(D) * np.eye(3) + 2 * material.mu * D


STRESS = {"NeoHookeanParameters": neo_hookean, "HookeParameters": hooke}


def speed(material, F, D):
    """Upper bound of the speeds of waves in the D directions, exact in 1D and for diagonal F."""
    J = np.linalg.det(F)
    if type(material).__name__ == "HookeParameters":
        return np.sqrt((material.lam + 2 * material.mu) * J / material.density)
    s2 = np.abs(F @ F.T)[:D, :D].sum(axis=1).max()
    along = material.mu + material.lam * (1 - np.log(J))
    return np.sqrt((material.mu * s2 + max(along, 0)) / material.density)


def weights(name, xi, L, half):
    """Weight S_vp and its gradient in 1D, xi = x_p - x_v; (35) for mpm, (40) for gimp."""
    r, sign = np.abs(xi), np.sign(xi)
    if name == "mpm":
        inside = r < L
        return np.where(inside, 1 - r / L, 0.0), np.where(inside, -sign / L, 0.0)
    assert name == "gimp"
    cases = [r < half, r < L - half, r < L + half]
    weight = [
        1 - (xi**2 + half**2) / (2 * L * half),
        1 - r / L,
        (L + half - r) ** 2 / (4 * L * half),
    ]
    slope = [-xi / (L * half), -sign / L, -sign * (L + half - r) / (2 * L * half)]
    return np.select(cases, weight, 0.0), np.select(cases, slope, 0.0)


class Reference:
    """A grid and the arrays on all its vertices: m (vertices), p, f, v, a (vertices, D)."""

    def __init__(self, name, per_cell, frame):
        self.name, self.frame = name, frame
        self.D = len(frame.cells)
        self.half = [0.5 * L / n for L, n in zip(frame.cell, per_cell, strict=True)]
        self.vertices = [
            origin + (np.arange(cells + 1 + 2 * frame.ghost) - frame.ghost) * L
            for origin, L, cells in zip(frame.origin, frame.cell, frame.cells, strict=True)
        ]
        self.shape = tuple(len(x) for x in self.vertices)

    def of(self, x):
        """S_vp, (vertices), and grad S_vp, (vertices, D), of a particle at x: products (19, 20)."""
        pairs = [
            weights(self.name, x[d] - self.vertices[d], self.frame.cell[d], self.half[d])
            for d in range(self.D)
        ]
        S = np.ones(self.shape)
        grad = np.ones((*self.shape, self.D))
        for d, (w, g) in enumerate(pairs):
            along = [1] * self.D
            along[d] = -1
            S = S * w.reshape(along)
            for i in range(self.D):
                grad[..., i] *= (g if i == d else w).reshape(along)
        return S, grad

    def particles_to_grid(self, particles):
        """(16), (21), (22)."""
        self.m = np.zeros(self.shape)
        self.p = np.zeros((*self.shape, self.D))
        self.f = np.zeros((*self.shape, self.D))
        for k in range(len(particles.m)):
            S, grad = self.of(particles.x[k])
            sigma = tensor(particles.sigma[k])[: self.D, : self.D]
            self.m += particles.m[k] * S
            self.p += particles.m[k] * S[..., None] * particles.v[k]
            self.f -= particles.V[k] * grad @ sigma

    def update_momentum(self, dt, gravity, faces, lightest):
        """(14) with (17), then the conditions of `faces`: (kind, axis, side, velocity, rate).

        Sets the impulse of each face, (faces, D), and the work of gravity and faces.
        """
        heavy = self.m > lightest
        m = np.where(heavy, self.m, 1.0)[..., None]
        b = np.asarray(gravity[: self.D], float)
        self.a = np.where(heavy[..., None], self.f / m + b, 0.0)
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
            before = self.a.copy()
            for d in range(self.D):
                where = behind.copy()
                v, a = 0.0, 0.0
                if kind == "slip":
                    where &= d == axis
                elif kind == "separating":
                    where &= (d == axis) & (self.v[..., d] * side > 0)
                elif kind == "velocity":
                    where &= velocity[d] is not None
                    v, a = velocity[d], rate[d]
                else:
                    assert kind == "fixed"
                self.v[where, d] = v
                self.a[where, d] = a
            force = m * (self.a - before)
            self.impulse.append(dt * force.reshape(-1, self.D).sum(axis=0))
        # Where faces meet, the velocity that counts is the one that all of them leave.
        self.work = dt * (m * (b + self.a - free) * self.v).sum()

    def grid_to_particles(self, particles, materials, material_of, dt, tracked):
        """(26), (27), (29), (30), volume and stress; and the largest (c + |v|)/L."""
        self.rate = 0.0
        for k in range(len(particles.m)):
            S, grad = self.of(particles.x[k])
            L = np.zeros((3, 3))
            for r in range(self.D):
                for c in range(self.D):
                    L[r, c] = (self.v[..., r] * grad[..., c]).sum()
            particles.x[k] += dt * np.tensordot(S, self.v, self.D)
            particles.v[k] += dt * np.tensordot(S, self.a, self.D)
            F = (np.eye(3) + dt * L) @ matrix(particles.F[k])
            particles.F[k] = F[: self.D, : self.D].reshape(-1)
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
