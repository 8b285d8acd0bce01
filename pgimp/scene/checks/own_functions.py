"""What functions of one's own return at the particles of the start."""

from __future__ import annotations

import numpy as np

from pgimp.case.locations import located
from pgimp.errors import CaseError
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.collective import all_or_none
from pgimp.mpi.communicator import Communicator
from pgimp.physics.exact.own import OwnSolution
from pgimp.physics.functions.call import evaluate, forces_at, states_at, vectors_at
from pgimp.physics.loads.own_force import OwnForce
from pgimp.scene.scene import Scene

#: Part of a cell's size that a solution may be displaced by at the start.
_SMALL = 1e-9


def asks(scene: Scene) -> list[str]:
    """Keys of the functions whose values at the particles are required."""
    force, exact = scene.case.body_force, scene.case.exact
    found = ["body-force"] if isinstance(force, OwnForce) else []
    found += ["exact"] if isinstance(exact, OwnSolution) else []
    fields = scene.interaction.loads.velocity_fields
    entries = scene.case.constraints.items() if fields else ()
    return found + [f"constraints.{name}.velocity" for name, entry in entries if entry.field]


def require_sound(scene: Scene, particles: Particles, count: int, comm: Communicator) -> None:
    """Refuse a body force or a prescribed velocity that is no number, and wrong solutions.

    A solution must be numbers, and begin without a displacement.

    At the start, at the first `count` particles; collective.

    Raises
    ------
    CaseError
        On every rank, if there is one.
    """
    if asks(scene):
        with located(scene.case):
            all_or_none(comm, lambda: _require_all(scene, particles, count), CaseError)


def _require_all(scene: Scene, particles: Particles, count: int) -> None:
    _require(scene, particles.x[:count])
    for number, (name, entry) in enumerate(scene.case.constraints.items(), 1):
        if entry.field:
            x = particles.x[:count][particles.constraint[:count, 0] == number]
            values, origin = np.zeros_like(x), (0.0,) * scene.dimension
            evaluate(entry.field.registered, vectors_at, (entry.field.source(), origin, x, values))
            _finite(f"constraints.{name}.velocity: {entry.field.registered}", x, values)


def _require(scene: Scene, x: np.ndarray) -> None:
    D, origin = scene.dimension, (0.0,) * scene.dimension
    force, exact = scene.case.body_force, scene.case.exact
    if isinstance(force, OwnForce):
        values = np.zeros((len(x), D))
        evaluate(force.registered, forces_at, (force.source(), origin, x, 0.0, values))
        _finite(f"body-force.function: {force.registered}", x, values)
    if isinstance(exact, OwnSolution):
        values = np.zeros((len(x), 2 * D + (3, 4, 6)[D - 1]))
        evaluate(exact.registered, states_at, (exact.source(), origin, x, 0.0, values))
        what = f"exact.function: {exact.registered}"
        _finite(what, x, values)
        far = np.abs(values[:, :D]).max(axis=1, initial=0.0)
        if (far > _SMALL * min(scene.domain.frame.cell)).any():
            row = int(np.argmax(far))
            raise CaseError(
                f"{what} begins with a displacement of {far[row]:.3g} at ({_listed(x[row])}); at "
                "time 0 particles are where the case has them: subtract it"
            )


def _finite(what: str, x: np.ndarray, values: np.ndarray) -> None:
    sound = np.isfinite(values).all(axis=1)
    if not sound.all():
        row = int(np.argmin(sound))
        raise CaseError(
            f"{what} returns ({_listed(values[row])}) at the particle at ({_listed(x[row])}), at "
            "time 0"
        )


def _listed(numbers: np.ndarray) -> str:
    return ", ".join(f"{each:.6g}" for each in numbers)


def force_without_value(scene: Scene, x: np.ndarray, t: float) -> str:
    """Describe what a body force of one's own returns at a place and time; empty for numbers.

    Of a place that is no number any more it is the middle of the domain.
    """
    force, frame = scene.case.body_force, scene.domain.frame
    if not isinstance(force, OwnForce):
        return ""
    middle = [
        o + 0.5 * n * h for o, n, h in zip(frame.origin, frame.cells, frame.cell, strict=True)
    ]
    place = np.where(np.isfinite(x), x, middle)[None]
    values = np.zeros_like(place)
    origin = (0.0,) * scene.dimension
    try:
        evaluate(force.registered, forces_at, (force.source(), origin, place, t, values))
    except CaseError as error:
        return str(error)
    if np.isfinite(values).all():
        return ""
    return (
        f"{force.registered} returns ({_listed(values[0])}) at ({_listed(place[0])}), t = {t:.6g}"
    )
