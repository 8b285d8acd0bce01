"""Force on a round bar between two smooth plates at large strain, by quadratic finite elements.

Plane strain, a neo-Hookean solid, a quarter of the section in nine-node quadrilaterals. Nodes that
would pass the plate lie on it, as long as it presses on them. Run it to see how it converges, and
that it tends to Hertz's force where the bar is pressed little:

    PYTHONPATH=scripts .venv/bin/python -m studies.auto.pressed_bar
"""

from itertools import product

import numpy as np
from studies.elements import lagrange, rule


def force(young, poisson, radius, approach, count, steps=6):
    """Force a length of the bar when the plates have come nearer by `approach`."""
    mu = young / (2.0 * (1.0 + poisson))
    lam = 2.0 * mu * poisson / (1.0 - 2.0 * poisson)
    bar = _Quarter(radius, count)
    place = bar.places.copy()
    for high in radius - 0.5 * approach * np.arange(1, steps + 1) / steps:
        pressed = place[:, 1] > high
        for _ in range(60):
            residual, stiffness = bar.forces(place, mu, lam)
            free = bar.free.copy()
            free[1::2] &= ~pressed
            step = np.zeros(place.size)
            step[1::2][pressed] = high - place[pressed, 1]
            rest = residual[free] + stiffness[np.ix_(free, ~free)] @ step[~free]
            step[free] = -np.linalg.solve(stiffness[np.ix_(free, free)], rest)
            place += step.reshape(-1, 2)
            residual, _ = bar.forces(place, mu, lam)
            now = (place[:, 1] > high) | (pressed & (residual[1::2] < 0.0))
            if np.array_equal(now, pressed) and np.abs(step).max() < 1e-10 * radius:
                break
            pressed = now
        else:
            raise RuntimeError("does not converge")
    return -2.0 * float(residual[1::2][pressed].sum())


class _Quarter:
    """Mesh of a quarter of a disk, `count` elements along both sides of a square bent to it."""

    def __init__(self, radius, count):
        n = 2 * count + 1
        s = np.linspace(0.0, 1.0, n)
        a, b = np.meshgrid(s, s, indexing="ij")
        places = a * np.sqrt(1.0 - 0.5 * b * b), b * np.sqrt(1.0 - 0.5 * a * a)
        self.places = radius * np.stack(places, axis=-1).reshape(-1, 2)
        self.free = np.ones((n, n, 2), dtype=bool)
        self.free[0, :, 0] = self.free[:, 0, 1] = False
        self.free = self.free.ravel()
        self.nodes = np.array([
            [(2 * i + p) * n + 2 * j + q for p in range(3) for q in range(3)]
            for i in range(count) for j in range(count)
        ])  # fmt: skip
        self.points = []
        for (x, wx), (y, wy) in product(zip(*rule(3), strict=True), repeat=2):
            (f, df), (g, dg) = lagrange(x), lagrange(y)
            slope = np.stack([np.outer(df, g).ravel(), np.outer(f, dg).ravel()])
            J = np.einsum("ka,eai->eki", slope, self.places[self.nodes])
            self.points.append((np.linalg.solve(J, slope[None]), wx * wy * np.linalg.det(J)))

    def forces(self, place, mu, lam):
        """Internal forces of the nodes, and their stiffness, both by displacement."""
        count, at = len(self.nodes), place[self.nodes]
        f, k = np.zeros((count, 9, 2)), np.zeros((count, 9, 2, 9, 2))
        one = np.eye(2)
        for slope, area in self.points:
            F = np.einsum("eai,eJa->eiJ", at, slope)
            back, log = np.linalg.inv(F), np.log(np.linalg.det(F))
            P = mu * F + (lam * log - mu)[:, None, None] * back.transpose(0, 2, 1)
            A = mu * np.einsum("ik,JL->iJkL", one, one) + lam * np.einsum(
                "eJi,eLk->eiJkL", back, back
            )
            A += np.einsum("e,eJk,eLi->eiJkL", mu - lam * log, back, back)
            f += np.einsum("e,eiJ,eJa->eai", area, P, slope)
            k += np.einsum("e,eiJkL,eJa,eLb->eaibk", area, A, slope, slope, optimize=True)
        at = (2 * self.nodes[:, :, None] + np.arange(2)).reshape(count, 18)
        residual, stiffness = np.zeros(place.size), np.zeros((place.size, place.size))
        np.add.at(residual, at, f.reshape(count, 18))
        np.add.at(stiffness, (at[:, :, None], at[:, None, :]), k.reshape(count, 18, 18))
        return residual, stiffness


def hertz(young, poisson, radius, approach):
    """Hertz's force, of a bar between two plates (Johnson, Contact Mechanics, 5.6)."""
    plane, found = young / (1.0 - poisson**2), young * approach
    for _ in range(100):
        half = np.sqrt(4.0 * found * radius / (np.pi * plane))
        found = approach * np.pi * plane / (2.0 * (2.0 * np.log(4.0 * radius / half) - 1.0))
    return float(found)


if __name__ == "__main__":
    for way in (0.003, 0.01, 0.03, 0.09):
        found = [force(1.0e6, 0.3, 0.3, way, count) for count in (8, 12, 16, 24)]
        print(way, *(f"{one:.1f}" for one in found), f"Hertz {hertz(1.0e6, 0.3, 0.3, way):.1f}")
