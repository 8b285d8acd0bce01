"""Small bodies: a wave, a beam that swings, a block that spins."""

from math import cos, hypot, pi, sin

import numpy as np
from studies.pareto.beam_mode import beam
from studies.pareto.problem_base import Problem, body_case, rms
from studies.scenes import box

#: Of all, so that they share their kernels; only the beam touches one.
WALLS = (("x-min", "fixed"), ("y-min", "unilateral"))


def swing_error(rate, u, v, start, m):
    """Error of a vibration after whole periods: of the velocity, and of the displacement by rate.

    So errors of the frequency, which at first hardly change the velocity, count as what is lost.
    """
    return rms(np.hstack([v - start, rate * u]), start, m)


class Waves(Problem):
    """A standing wave in a free bar that is one wavelength long, after two periods.

    v_x = A cos(2 pi x) cos(2 pi t), exact for small amplitudes.
    """

    walls = WALLS
    amplitude, periods = 1e-4, 2.0

    def __init__(self, D):
        super().__init__("waves", D)
        self.sizes, self.quick = ((16, 32, 64) if D == 2 else (8, 16, 24)), 8

    def case(self, method, n):
        h, low, half = 1.0 / n, (4.0 + self.off) / n, n // 2
        region = box([low] * self.D, [low + 1.0, *[low + 0.5] * (self.D - 1)])
        size = [n + 9, half + 9, half + 9]
        return body_case(self, method, size, h, region, self.periods)

    def start(self, X, n):
        x = 2.0 * pi * (X[:, 0] - (4.0 + self.off) / n)
        v, L = np.zeros((len(X), self.D)), np.zeros((len(X), self.D, self.D))
        v[:, 0] = self.amplitude * np.cos(x)
        L[:, 0, 0] = -2.0 * pi * self.amplitude * np.sin(x)
        return v, L

    def error(self, n, X, x, v, m):
        return swing_error(2.0 * pi, x - X, v, self.start(X, n)[0], m)


class Bending(Problem):
    """A beam four times as long as high swings in its slowest mode, for one period.

    The mode is that of quadratic finite elements; its tip moves by a twentieth of the height.
    """

    walls = WALLS
    amplitude = 0.05

    def __init__(self, D):
        super().__init__("bending", D)
        self.sizes, self.quick = ((6, 12, 20) if D == 2 else (3, 5)), 2

    def case(self, method, n):
        h, low = 1.0 / n, (4.0 + self.off) / n
        region = box([0.0, *[low] * (self.D - 1)], [4.0, *[low + 1.0] * (self.D - 1)])
        end = 2.0 * pi / beam().rate
        return body_case(self, method, [4 * n + 4, n + 9, n + 9], h, region, end)

    def start(self, X, n):
        shape, slope = beam().at(X[:, :2] - [0.0, (4.0 + self.off) / n])
        v, L = np.zeros((len(X), self.D)), np.zeros((len(X), self.D, self.D))
        v[:, :2] = self.amplitude * beam().rate * shape
        L[:, :2, :2] = self.amplitude * beam().rate * slope
        return v, L

    def error(self, n, X, x, v, m):
        return swing_error(beam().rate, x - X, v, self.start(X, n)[0], m)


class Spinning(Problem):
    """A free block turns once, in 3D about (1, 2, 3), its edges at a fiftieth of the wave speed.

    It turns as a rigid one but for being stretched: the stretch r a, with a = (rate R)^2/3 in the
    mean for the half side R (Ritz), slows it by 2 a.
    """

    walls = WALLS
    speed = 0.02

    def __init__(self, D):
        super().__init__("spinning", D)
        self.sizes, self.quick = ((6, 12, 18) if D == 2 else (4, 6)), 2
        self.rate = self.speed / 0.5
        self.axis = np.array([0.0, 0.0, 1.0] if D == 2 else [1.0, 2.0, 3.0])
        self.axis /= hypot(*self.axis)

    def case(self, method, n):
        low = (n // 2 + 2 + self.off) / n
        region = box([low] * self.D, [low + 1.0] * self.D)
        rate = self.rate if self.D == 2 else (self.rate * self.axis).tolist()
        motion = {"rotation": {"about": [low + 0.5] * self.D, "rate": rate}}
        size = [2 * n + 5] * self.D
        case = body_case(self, method, size, 1.0 / n, region, 2.0 * pi / self.rate)
        case["bodies"]["body"]["velocity"] = motion
        return case

    def error(self, n, X, x, v, m):
        Z = X - (n // 2 + 2 + self.off) / n - 0.5
        Z, place = np.pad(Z, ((0, 0), (0, 3 - self.D))), x - (n // 2 + 2 + self.off) / n - 0.5
        angle = -2.0 * pi * 2.0 * self.speed**2 / 3.0  # past the whole turn
        along = np.outer(Z @ self.axis, self.axis)
        across = np.cross(self.axis, Z)
        exact = along + cos(angle) * (Z - along) + sin(angle) * across
        return rms(place - exact[:, : self.D], Z - along, m)
