"""What an impact law could keep of an elastic impact: two bars of lumped masses, in 1D.

The model is the scheme of the initial configuration: vertices with their displacement and velocity,
symplectic Euler. It asks what three laws of impact keep, without any error of gaps or normals.
"""

import numpy as np
from studies.harness import table
from studies.initial.impacts import CELLS, PARTED, SPEED

COURANT = 0.3
#: Law of impact, its number, and its words. The stiffness is in those of a cell, E/h.
LAWS = (
    ("restitution", 0.0, "impulse that stops the approach (what pgimp does)"),
    ("restitution", 0.5, "impulse that reverses half of the approach"),
    ("restitution", 1.0, "impulse that reverses the approach"),
    ("stiffness", 0.5, "contact stiffness of half a cell's"),
    ("stiffness", 0.25, "contact stiffness of a quarter of a cell's"),
)


def bars(law, number, cells):
    """Two bars of length 1 that meet: restitution, and part of the energy that is lost.

    Young's modulus and the density are 1. Bars touch at the start.
    """
    h = 1.0 / cells
    dt, m = COURANT * h, np.full(cells + 1, h)
    m[[0, -1]] *= 0.5
    u = np.zeros((2, cells + 1))  # the first bar's last vertex meets the other's first
    v = np.array([[SPEED], [-SPEED]]) * np.ones_like(u)
    kinetic = 0.5 * (m * v**2).sum()
    for _ in range(round(PARTED / dt)):
        force = np.zeros_like(u)
        stress = np.diff(u) / h
        force[:, :-1] += stress
        force[:, 1:] -= stress
        gap, before = u[1, 0] - u[0, -1], v[1, 0] - v[0, -1]
        v += dt * force / m
        rate = v[1, 0] - v[0, -1]
        if law == "stiffness":
            J = dt * max(0.0, -number / h * gap)
        elif gap + dt * rate < 0.0:
            J = max(0.0, number * max(0.0, -before) - rate) * 0.5 * m[0]
        else:
            J = 0.0
        v[0, -1] -= J / m[-1]
        v[1, 0] += J / m[0]
        u += dt * v
    left = 0.5 * (m * v**2).sum() + 0.5 * (np.diff(u) ** 2).sum() / h
    parted = (m * (v[1] - v[0])).sum() / (2.0 * SPEED * m.sum())
    return float(parted), float(1.0 - left / kinetic)


def text(note):
    """The table of all laws and sizes of cells."""
    rows = []
    for law, number, words in LAWS:
        found = [bars(law, number, cells) for cells in CELLS]
        rows.append((
            words, ", ".join(f"{one:.3f}" for one, _ in found),
            ", ".join(f"{100.0 * lost + 0.0:.2f}" for _, lost in found),
        ))  # fmt: skip
    return table(("law of impact", "restitution", "energy lost, %"), rows, note)
