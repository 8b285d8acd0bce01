"""A case for each exact solution, as dictionaries, and the solution's state asked from Python."""

from copy import deepcopy

import numpy as np
from reference_materials import tensor
from scenes import scene

from pgimp.case.schema import Case
from pgimp.jit.kernel import kernel
from pgimp.physics.exact.base import body_force, state

YOUNG, DENSITY, WALL, LENGTH = 400.0, 2.0, -1.0, 5.0
BAR = {"model": "linear-1d", "young": YOUNG, "density": DENSITY}
SPEED = np.sqrt(YOUNG / DENSITY)
#: Its shear waves take as long across the ring as this takes to turn.
SLOW = {"model": "neo-hookean", "young": 1.0, "poisson": 0.3, "density": 1.0}
STIFF = {"model": "neo-hookean", "young": 200.0, "poisson": 0.0, "density": 2.0}


def bar(exact, cells=6, boundaries=None, velocity=None, **parts):
    """A bar of five units in a domain that starts at x = -1 with a wall."""
    region = {"box": {"min": [WALL], "max": [WALL + LENGTH]}}
    body = {"material": "bar", "region": region}
    body |= {"velocity": [velocity]} if velocity else {}
    case = scene(
        1,
        body,
        cells=[cells],
        boundaries={"x-min": "fixed"} if boundaries is None else boundaries,
        materials={"bar": BAR},
        exact=exact,
        **parts,
    )
    case["grid"]["origin"] = [WALL]
    return case


def ramp(*rows):
    return {"table": [[t, [b]] for t, b in rows]}


def ring(cell=0.125, **parts):
    """A ring of radii 0.75 and 1.25 about (0.1, -0.2); at its full turn it is sheared by 0.92."""
    parts.setdefault("exact", {"generalized-vortex": {"amplitude": 0.15, "period": 2.0}})
    balls = [{"ball": {"centre": [0.1, -0.2], "radius": r}} for r in (1.25, 0.75)]
    body = {"material": "soft", "region": {"difference": balls}}
    cells = round(3.0 / cell)
    parts = {"end": 1.0, "step": 0.01, "materials": {"soft": SLOW}} | parts
    case = scene(2, body, cells=[cells] * 2, cell=cell, **parts)
    case["grid"]["origin"] = [-1.4, -1.7]
    return case


def block(dimension, cell=0.25, **parts):
    """A block of sides 1, 1.5 and 1 that stretches, turns and flies."""
    exact = {
        "stretch": [0.4, -0.25, 0.35][:dimension],
        "period": 1.0,
        "rate": 3.0,
        "translation": [0.2, -0.1, 0.3][:dimension],
    }
    high = [0.5, 1.0, 0.5][:dimension]
    region = {"box": {"min": [-0.5] * dimension, "max": high}}
    parts = {"end": 1.0, "step": 0.01, "materials": {"soft": STIFF}} | parts
    body = {"material": "soft", "region": region}
    case = scene(
        dimension,
        body,
        cells=[round(4.0 / cell)] * dimension,
        cell=cell,
        **{"exact": {"spinning-block": exact}} | parts,
    )
    case["grid"]["origin"] = [-2.0] * dimension
    return case


TWO_RAMPS = ramp((0.0, 0.0), (1.0, -6.0), (1.5, 4.0))
CASES = {
    "compaction": bar("compaction", gravity=TWO_RAMPS),
    "dynamic": bar({"compaction": {"dynamic": True}}, gravity=ramp((0.0, 0.0), (1.0, -6.0))),
    "shock": bar("shock", velocity=-0.2 * SPEED, end=0.7, step=0.01),
    "free": bar({"vibrating-bar": {"amplitude": 0.3, "mode": 2}}),
    "held": bar(
        {"vibrating-bar": {"amplitude": 0.3, "mode": 3, "end": "held"}},
        cells=5,
        boundaries={"x-min": "slip", "x-max": "fixed"},
    ),
    "vortex": ring(),
    "block2d": block(2),
    "block3d": block(3),
}


@kernel
def state_at(solution, X, x, t):
    return state(solution, X, x, t)


@kernel
def force_at(solution, X, t):
    return body_force(solution, X, t)


class Exact:
    """Exact solution of a case; positions and vectors are (D,), tensors (3, 3)."""

    def __init__(self, case):
        self.case = Case.model_validate(deepcopy(case))
        self.solution = self.case.exact.parameters(self.case)
        self.D = self.case.dimensions
        ((_, body),) = self.case.bodies.items()
        self.region = body.region
        self.material = self.case.materials[body.material]

    def state(self, X, t, x=None):
        """Displacement, velocity and Cauchy stress of the material point, at `x` if given."""
        X = tuple(map(float, X))
        if x is None:
            u = state_at(self.solution, X, X, t)[0]
            x = np.add(X, u)
        u, v, sigma = state_at(self.solution, X, tuple(map(float, x)), t)
        return np.array(u), np.array(v), tensor(sigma)

    def force(self, X, t):
        return np.array(force_at(self.solution, tuple(map(float, X)), t))

    def gradient(self, X, t, h=1e-4):
        """Deformation gradient by central differences of fourth order, (3, 3)."""
        F = np.eye(3)
        for j in range(self.D):
            F[: self.D, j] += slope(lambda s, e=np.eye(self.D)[j]: self.state(X + s * e, t)[0], h)
        return F

    def piola(self, X, t):
        """First Piola stress from the exact Cauchy stress; the bar's section does not change."""
        F = self.gradient(X, t)
        J = np.linalg.det(F) if self.D > 1 else F[0, 0]
        return J * self.state(X, t)[2] @ np.linalg.inv(F).T

    def divergence(self, X, t, h=1e-3):
        D = self.D
        columns = [
            slope(lambda s, j=j: self.piola(X + s * np.eye(D)[j], t)[:D, j], h) for j in range(D)
        ]
        return np.sum(columns, axis=0)


def slope(function, h):
    """Derivative at 0, of fourth order in h."""
    near = function(h) - function(-h)
    far = function(2 * h) - function(-2 * h)
    return (8 * near - far) / (12 * h)
