"""A step in the initial configuration in plain NumPy, for bodies of any shape and material."""

import numpy as np
from reference import Reference
from reference_materials import STRESS, matrix, tensor, voigt

from pgimp.kernels.update.mean_dilatation_lagrangian import MIN_FILL


class Lagrangian(Reference):
    """The method on the grid of the start: weights of the first places of undeformed particles.

    f = -sum V0 P grad0 S with P = J s F^-T, and F grows by dt sum v (x) grad0 S (de Vaucorbeil,
    Nguyen and Hutchinson 2020). With mean dilatation as in
    `pgimp.kernels.update.mean_dilatation_lagrangian`.
    """

    def weights_of(self, p, k):
        return self.of(p.origin[k], np.eye(self.D).ravel())

    def dilatations_of(self, p, k):
        return self.dilatation_of(p.origin[k], np.eye(self.D).ravel())

    def company(self, p, k):
        """Mean of the vertices' masses over a particle's cells, of a full one's."""
        half = self.half
        near = np.ones(())
        for d, along in enumerate(self.vertices):
            low = np.maximum(along[:-1], p.origin[k, d] - half[d])
            high = np.minimum(along[1:], p.origin[k, d] + half[d])
            part = np.maximum(high - low, 0.0) / (2.0 * half[d])
            near = np.multiply.outer(near, 0.5 * (np.append(part, 0.0) + np.append(0.0, part)))
        return (near * self.m).sum() * p.V0[k] / (p.m[k] * np.prod(self.frame.cell))

    def particles_to_grid(self, p):
        D = self.D
        self.m = np.zeros(self.shape)
        self.p, self.f = np.zeros((2, *self.shape, D))
        for k in range(len(p.m)):
            S, grad = self.weights_of(p, k)
            F = matrix(p.F[k])
            sigma = tensor(p.sigma[k])
            if p.cell_F.shape[1]:
                mean = (1.0 - p.isolation[k, 0]) * np.trace(sigma[:D, :D]) / D
                G = matrix(p.cell_F[k])
                P = np.linalg.det(G) * mean * np.linalg.inv(G).T
                self.f -= p.V0[k] * self.dilatations_of(p, k) @ P[:D, :D].T
                sigma = p.fbar_ratio[k, 0] * (sigma - mean * np.eye(3))
            J = np.linalg.det(F) if D > 1 else F[0, 0]
            P = J * sigma @ np.linalg.inv(F).T
            self.m += p.m[k] * S
            self.p += p.m[k] * S[..., None] * p.v[k]
            self.f -= p.V0[k] * grad @ P[:D, :D].T
        self.particles = p

    def gains(self, v, a, dt):
        """Vertices keep all of the change."""
        return self.v - v

    def grid_to_particles(self, p, materials, material_of, dt):
        D = self.D
        for k in range(len(p.m)):
            S, grad = self.weights_of(p, k)
            rate = np.zeros((3, 3))
            rate[:D, :D] = np.tensordot(np.moveaxis(self.v, -1, 0), grad, D)
            p.x[k] += dt * np.tensordot(S, self.v, D)
            p.v[k] = np.tensordot(S, self.v, D)
            F = matrix(p.F[k])
            if p.cell_F.shape[1]:
                F[:D, :D] /= p.fbar_ratio[k]
                p.isolation[k] = p.isolation[k] or self.company(p, k) < MIN_FILL**D
                cells = np.tensordot(np.moveaxis(self.v, -1, 0), self.dilatations_of(p, k), D)
                p.cell_F[k] += dt * cells.ravel()
                G = np.linalg.det(matrix(p.cell_F[k]))
                new = F + dt * rate
                if not p.isolation[k, 0]:
                    p.fbar_ratio[k] = (G / np.linalg.det(new)) ** (1 / D)
                new[:D, :D] *= p.fbar_ratio[k]
                L = (new @ np.linalg.inv(matrix(p.F[k])) - np.eye(3)) / dt
                F = new
            else:
                L = rate @ np.linalg.inv(F)
                F = F + dt * rate
            p.F[k] = F[:D, :D].ravel()
            J = np.linalg.det(F)
            p.V[k] = J * p.V0[k]
            material = materials[material_of[p.body[k]]]
            if type(material).__name__ == "Linear1dParameters":
                sigma = np.diag([material.young * (F[0, 0] - 1.0), 0.0, 0.0])
            else:
                law = STRESS[type(material).__name__]
                sigma = law(material, F, tensor(p.sigma[k]), dt * L)
            p.sigma[k] = voigt(sigma, p.sigma.shape[1])
