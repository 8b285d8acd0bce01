"""Deflection of the cantilever of cases/hard/bending.yaml by quadratic finite elements.

Small strain; nine-node quadrilaterals whose volume change is integrated at 2 x 2 points (selective
reduced integration, Malkus and Hughes 1978), so that they do not lock.
"""

import numpy as np
from studies.elements import Mesh


def mean_deflection(young, poisson, length, height, traction, elements):
    """Mean of u_y over the beam, held at x = 0, under a shear traction at x = length."""
    mesh = Mesh(length, height, elements)
    mu = young / (2.0 * (1.0 + poisson))
    lam = 2.0 * mu * poisson / (1.0 - 2.0 * poisson)
    stiffness, mean = np.zeros((18, 18)), np.zeros(9)
    C = mu * np.diag([2.0, 2.0, 1.0])
    for B, functions, area in mesh.points(3):
        stiffness += area * B.T @ C @ B
        mean += area * functions
    for B, _, area in mesh.points(2):
        trace = B[0] + B[1]
        stiffness += lam * area * np.outer(trace, trace)
    average, force = np.zeros(2 * mesh.nodes), np.zeros(2 * mesh.nodes)
    for i, at in mesh.displacements():
        average[at[1::2]] += mean
        if i == elements[0] - 1:
            end = traction * mesh.size[1] * np.array([1.0, 4.0, 1.0]) / 6.0
            force[at[[13, 15, 17]]] += end
    u = np.zeros(2 * mesh.nodes)
    u[mesh.free] = np.linalg.solve(mesh.matrix(stiffness), force[mesh.free])
    return float(average @ u) / (length * height)
