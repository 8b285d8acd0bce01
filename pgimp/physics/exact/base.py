"""Base of the entries of exact solutions, and the kernels' view of a solution."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple

from pgimp.jit.kernel import class_of, inlined
from pgimp.physics.boundaries import BOUNDARIES
from pgimp.schema.base import Model
from pgimp.schema.problems import Problem
from pgimp.schema.registries import name_of


class Solution(Model):
    """Base of the entries ``exact``: the solution of one body of one material model."""

    #: Whether the motion needs a body force of its own: a manufactured solution.
    forced: ClassVar[bool] = False
    #: Whether the solution gives the particles their initial velocity.
    moves: ClassVar[bool] = False
    #: Material model of the solution, or several.
    model: ClassVar[str | tuple[str, ...]]

    @property
    def walls(self) -> Mapping[str, tuple[str, ...]]:
        """Faces that need a condition, with the allowed ones; all other faces must be open."""
        return {}

    def problems(self, case: Any) -> Iterator[Problem]:
        """Yield the problems of an otherwise sound case with this solution; paths from its top."""
        if case.dimensions not in self.DIMENSIONS:
            allowed = " and ".join(f"{d}D" for d in self.DIMENSIONS)
            yield Problem(
                ("exact",),
                f"the solution exists in {allowed} only, but the case has {case.dimensions}D",
            )
            return
        if len(case.bodies) != 1:
            text = f"the exact solution is that of one body, but the case has {len(case.bodies)}"
            yield Problem(("bodies",), text)
            return
        ((name, body),) = case.bodies.items()
        found = case.materials[body.material].model
        models = (self.model,) if isinstance(self.model, str) else self.model
        if found not in models:
            path = ("materials", body.material, "model")
            yield Problem(path, f"the exact solution needs {' or '.join(models)}, got {found}")
            return
        for keys in case.materials[body.material].variations:
            text = "the exact solution is that of a uniform body; give a number"
            yield Problem(("materials", body.material, *keys), text)
        yield from self.wrong_walls(case.boundaries)
        for key in ("body-force", "water", "tractions", "constraints"):
            if getattr(case, key.replace("-", "_"), None):
                yield Problem((key,), "the exact solution has none; leave this out")
        for rigid_body in case.rigid_bodies:
            yield Problem(
                ("bodies", rigid_body), "the exact solution has no rigid body; leave it out"
            )
        yield from self.mismatches(case, name, body)

    def wrong_walls(self, boundaries: Any) -> Iterator[Problem]:
        """As `problems`, of the conditions on faces."""
        for face, allowed in self.walls.items():
            path, names = ("boundaries", face), " or ".join(allowed)
            if face not in boundaries:
                yield Problem(path, f"missing; the exact solution has a wall there: {names}", True)
            elif (found := name_of(boundaries[face], BOUNDARIES)) not in allowed:
                yield Problem(path, f"the exact solution needs {names}, got {found}")
        for face in boundaries:
            if face not in self.walls:
                yield Problem(
                    ("boundaries", face), "the exact solution has nothing there; leave this out"
                )

    @abstractmethod
    def mismatches(self, case: Any, name: str, body: Any) -> Iterator[Problem]:
        """As `problems`, specific to the solution; `name` is the body's."""

    @abstractmethod
    def parameters(self, case: Any) -> Any:
        """Parameters of the kernels, from a case without problems."""


def no_gravity(case: Any) -> Iterator[Problem]:
    """Yield a problem where the case has gravity."""
    if case.gravity is not None:
        yield Problem(("gravity",), "the exact solution has none; leave this out")


class BodyForce(NamedTuple):
    """Body force at a time, from a manufactured solution or from `pgimp.physics.loads`."""

    source: Any
    time: float


@inlined
def state(solution, X, x, t):
    """Exact displacement, velocity and Cauchy stress of a particle initially at `X`, now at `x`.

    Positions and vectors are tuples of D numbers; the stress is a tuple as in ``particles.sigma``.
    """
    return class_of(solution).state(solution, X, x, t)


@inlined
def body_force(solution, X, t):
    """Body force per mass on the particle initially at `X`, a tuple of D numbers."""
    return class_of(solution).force(solution, X, t)
