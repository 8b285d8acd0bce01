"""Tensors, stress and waves of the simplest materials in plain NumPy, from their equations.

Matrices are (3, 3) also in 1D and 2D (plane strain).
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
