"""The slope of cases/shaken-slope.yaml by finite elements, once it swings with its base.

Independent of particles and of steps in time: linear equations for complex velocities over the
base's, of quadratic elements of nine nodes. Their columns end at the surface. Faces at the sides
have the dashpots of Lysmer and Kuhlemeyer (1969), rho c_p across and rho c_s along.
"""

from tempfile import TemporaryDirectory

import numpy as np
from studies.harness import CASES

import pgimp

#: Length of the ground, where the slope begins and ends, and heights there.
LENGTH, TOE, CREST, LOW, HIGH = 240.0, 80.0, 90.0, 10.0, 20.0
FREQUENCY, SIZE = 2.0, 0.01
#: Rate of the damping over the angular frequency: twice the damping ratio.
DAMPING = 0.2
YOUNG, POISSON, DENSITY = 2.08e8, 0.3, 2000.0
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))
LAME = 2.0 * SHEAR * POISSON / (1.0 - 2.0 * POISSON)
SPEEDS = np.sqrt((LAME + 2.0 * SHEAR) / DENSITY), np.sqrt(SHEAR / DENSITY)
GAUSS = tuple(zip(*np.polynomial.legendre.leggauss(3), strict=True))


def along(a):
    """Quadratic functions of three nodes at -1, 0 and 1, and their derivatives."""
    values = np.array([0.5 * a * (a - 1.0), 1.0 - a * a, 0.5 * a * (a + 1.0)])
    return values, np.array([a - 0.5, -2.0 * a, a + 0.5])


def element(places):
    """Stiffness and mass of an element: displacements of each node along x and y."""
    stiffness, mass = np.zeros((18, 18)), np.zeros((18, 18))
    for a, weight_a in GAUSS:
        for b, weight_b in GAUSS:
            (fa, da), (fb, db) = along(a), along(b)
            by = np.stack([np.outer(da, fb).ravel(), np.outer(fa, db).ravel()])
            jacobian = by @ places
            weight = weight_a * weight_b * np.linalg.det(jacobian)
            slope = np.linalg.solve(jacobian, by)
            stretch, shear = np.zeros((2, 18)), np.zeros(18)
            stretch[0, 0::2], stretch[1, 1::2] = slope
            shear[0::2], shear[1::2] = slope[1], slope[0]
            wide = stretch.sum(axis=0)
            stiffness += weight * (
                LAME * np.outer(wide, wide)
                + 2.0 * SHEAR * stretch.T @ stretch
                + SHEAR * np.outer(shear, shear)
            )
            for part in range(2):
                f = np.outer(fa, fb).ravel()
                mass[part::2, part::2] += weight * DENSITY * np.outer(f, f)
    return stiffness, mass


def column(wide, left, right, rows, w):
    """Dynamic stiffness of a column of elements between two heights, on three lines of nodes."""
    size = 2 * (2 * rows + 1)
    whole = np.zeros((3 * size, 3 * size), complex)
    x, high = np.linspace(0.0, wide, 3), np.linspace(left, right, 3)
    for row in range(rows):
        y = np.outer(high, np.linspace(row, row + 1, 3) / rows)
        stiffness, mass = element(np.stack([np.repeat(x, 3), y.ravel()], axis=1))
        first = np.arange(3)[:, None] * size + 4 * row + np.arange(6)
        own = first.ravel()
        whole[np.ix_(own, own)] += stiffness - w * w * (1.0 - 1j * DAMPING) * mass
    return whole


def dashpots(high, rows, w):
    """Those of a face of some height."""
    size = 2 * (2 * rows + 1)
    whole = np.zeros((size, size), complex)
    part = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) * high / rows / 30.0
    for row in range(rows):
        for way, speed in enumerate(SPEEDS):
            own = 4 * row + way + 2 * np.arange(3)
            whole[np.ix_(own, own)] += 1j * w * DENSITY * speed * part
    return whole


class Elements:
    """The solution: complex velocities over the base's, which moves along x alone."""

    def __init__(self, cell=1.0, frequency=FREQUENCY, low=LOW, high=HIGH, length=LENGTH):
        rows, w = round(high / cell), 2.0 * np.pi * frequency
        self.rows, self.lines = rows, np.linspace(0.0, length, round(length / cell) + 1)
        self.heights = np.interp(self.lines, [TOE, CREST], [low, high])
        size = 2 * (2 * rows + 1)
        free = np.arange(3 * size).reshape(3, size)[:, 2:].ravel()
        held, ends, inner = [0, size, 2 * size], size - 2, 2 * (size - 2)
        known, kept = {}, []
        # Lines of nodes are taken out from the left on: what remains of them is `rest` and `push`.
        rest, push = dashpots(low, rows, w)[2:, 2:], np.zeros(ends)
        for number, wide in enumerate(np.diff(self.lines)):
            form = tuple(np.round([wide, *self.heights[number : number + 2]], 9).tolist())
            if form not in known:
                known[form] = column(*form, rows, w)
            a = known[form][np.ix_(free, free)]
            force = -known[form][np.ix_(free, held)].sum(axis=1)
            a[:ends, :ends] += rest
            force[:ends] += push
            solved = np.linalg.solve(a[:inner, :inner], np.c_[a[:inner, inner:], force[:inner]])
            rest = a[inner:, inner:] - a[inner:, :inner] @ solved[:, :-1]
            push = force[inner:] - a[inner:, :inner] @ solved[:, -1]
            kept.append(solved)
        last = np.linalg.solve(rest + dashpots(high, rows, w)[2:, 2:], push)
        # By column, line of nodes, node from below, direction.
        self.values = np.zeros((len(kept), 3, size // 2, 2), complex)
        self.values[:, :, 0, 0] = 1.0
        for number, solved in reversed(list(enumerate(kept))):
            before = solved[:, -1] - solved[:, :-1] @ last
            self.values[number, :, 1:] = np.concatenate([before, last]).reshape(3, -1, 2)
            last = before[:ends]

    def at(self, x, y=None):
        """Velocity along x and y at a place, or on the surface."""
        n = min(max(int(np.searchsorted(self.lines, x)) - 1, 0), len(self.lines) - 2)
        left, right = self.lines[n : n + 2]
        deep = self.rows * (1.0 if y is None else y / np.interp(x, self.lines, self.heights))
        row = min(int(deep), self.rows - 1)
        across, up = 2.0 * (x - left) / (right - left) - 1.0, 2.0 * (deep - row) - 1.0
        nodes = self.values[n, :, 2 * row : 2 * row + 3]
        return np.einsum("a,b,abd->d", along(across)[0], along(up)[0], nodes)


def level(high, frequency=FREQUENCY):
    """Velocity of the surface of level ground without sides, over its base's."""
    w = 2.0 * np.pi * frequency
    return 1.0 / np.cos(w * np.sqrt(1.0 - 1j * DAMPING) * high / SPEEDS[1])


def swing(time, velocity, frequency=FREQUENCY):
    """Complex velocity over the base's, from the last two periods."""
    w, late = 2.0 * np.pi * frequency, time > time[-1] - 2.0 / frequency + 1e-9
    waves = np.stack([np.sin(w * time[late]), np.cos(w * time[late])], axis=1)
    a, b = np.linalg.lstsq(waves, velocity[late] / SIZE, rcond=None)[0]
    return a + 1j * b


def watched(run, frequency=FREQUENCY):
    """Probes of a run by name: where each begins, and its velocity over the base's."""
    return {
        name: (
            (probe["position-x"][0], probe["position-y"][0]),
            np.array([swing(probe["time"], probe[f"velocity-{k}"], frequency) for k in "xy"]),
        )
        for name, probe in run.probes.items()
    }


def compared(cell, solution):
    """Run the case in cells of some size: by probe what it finds and what elements find there."""
    with TemporaryDirectory() as folder:
        changes = [f"grid.cell=[{cell},{cell}]", "output.every=6.0"]
        run = pgimp.run(
            CASES / "shaken-slope.yaml", output=f"{folder}/run", overrides=changes, quiet=True
        )
        return {name: (v, solution.at(*place)) for name, (place, v) in watched(run).items()}


def error(pair):
    """Length of the difference of complex velocities over that of the second."""
    return float(np.linalg.norm(pair[0] - pair[1]) / np.linalg.norm(pair[1]))


def slope_rows():
    """Place, velocity by elements, its lag, and the errors of cells of 2 and 1 m."""
    solution = Elements()
    coarse, fine = compared(2.0, solution), compared(1.0, solution)
    for name, pair in fine.items():
        x = pair[1][0]
        yield [name, f"{abs(x):.3f}", f"{-np.angle(x):.3f}",
               f"{100.0 * error(coarse[name]):.2f} %", f"{100.0 * error(pair):.2f} %"]  # fmt: skip


#: Frequencies over that of level ground, and distances from a side over the ground's height.
PARTS, AWAY = (0.5, 0.8, 1.0), (0, 1, 2, 4, 6, 8)


def side_rows():
    """Frequency, and by distance from the side the surface's velocity over level ground's."""
    for part in PARTS:
        frequency = part * SPEEDS[1] / (4.0 * HIGH)
        solution = Elements(2.0, frequency, HIGH, HIGH, 20.0 * HIGH)
        free = level(HIGH, frequency)
        found = [abs(solution.at(HIGH * away)[0] / free) for away in AWAY]
        yield [f"{part:g}", f"{abs(free):.2f}", *(f"{value:.2f}" for value in found)]
