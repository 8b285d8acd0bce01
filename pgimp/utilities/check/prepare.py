"""Set-up of a case in ``pgimp check``, before the simulation, with its errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles, present
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.checks.facts import BodyFacts, Findings, examine
from pgimp.scene.checks.warned import Warned
from pgimp.scene.geometry import share
from pgimp.scene.rigid.checks import require_apart, require_clear, require_slow
from pgimp.scene.scene import Scene
from pgimp.scene.settings import MOST_CELLS
from pgimp.solver.sources.inflow import most_at_once, to_enter
from pgimp.solver.start.memory import Estimate
from pgimp.solver.start.require_memory import require
from pgimp.solver.start.validate_stages import look_ahead, require_stable_stages
from pgimp.solver.time.stability import require_end, require_stable
from pgimp.utilities.check.particles import look_at_particles


class Prepared(NamedTuple):
    """A case that is ready to run."""

    scenes: list[Scene]  #: Scenes of all stages.
    #: lattice, counts, notes: See `count_particles`; of the bodies that are there at the start. A
    #: note more names what was not looked at.
    lattice: Lattice
    counts: np.ndarray
    notes: list[str]
    memory: Estimate  #: Memory of one rank.
    found: Findings  #: Facts about the bodies.
    varied: dict[str, float]  #: Rates of bodies whose materials vary.
    of_stages: list[Warned]  #: Warnings about steps of later stages.
    #: crossing, rate, dt: Cells per unit of length, 0 if the grid moves with the bodies. Reference
    #: rate of the case's Courant number, cells per unit of time. The first step.
    crossing: float
    rate: float
    dt: float
    entering: dict[str, int]  #: Particles that enter by inflow until the end.


def prepare(whole: Case) -> Prepared:
    """Set up a case as in a run, with its particles a block at a time.

    Raises
    ------
    CaseError
        For errors that would stop a run before its first step.
    """
    case = whole.stages[0]
    scenes = [Scene(each) for each in whole.stages]
    if whole.time.stages:
        look_ahead(scenes)
    scene = scenes[0]
    share(case, Serial())
    require(scene, Serial())
    lattice, counts, notes = count_particles(scene, Serial())
    entering = to_enter(case, counts, whole.time.last)
    memory = require(scene, Serial(), most_at_once(case, counts, entering))
    found = examine(scene, lattice, counts, whole.stages)
    counts = present(scene, counts)
    notes += look_at_particles(scene, lattice, counts)
    if scene.interaction.rigid_bodies:
        _look_at_rigid(scene, lattice, counts)
    varied = {body.name: body.rest_rate for body in found.bodies if body.varies}
    of_stages = require_stable_stages(scenes, varied)
    # A grid of the initial configuration moves with its bodies.
    crossing = 0.0 if scene.settings.initial else max(scene.domain.frame.inverse)
    rate = _rate(case, found.bodies, crossing)
    require_end(scene, max(rate, scene.interaction.rigid_bodies.first_rate))
    dt = _step(scene, rate)
    require_slow(scene.interaction.rigid_bodies, dt)
    return Prepared(
        scenes,
        lattice,
        counts,
        notes,
        memory,
        found,
        varied,
        of_stages,
        crossing,
        rate,
        dt,
        entering,
    )


def _rate(case: Case, bodies: list[BodyFacts], inverse: float) -> float:
    """Reference rate of the case's Courant number, cells per unit of time."""
    if case.watched:
        assert case.courant is not None
        return pace_of(case.courant, bodies, inverse)
    return max(body.rest_rate + body.top_speed * inverse for body in bodies)


def pace_of(courant: float, bodies: Sequence[BodyFacts], inverse: float) -> float:
    """Reference rate of a Courant number chosen by pgimp, see `Settings.controlled`."""
    part = courant / MOST_CELLS * inverse
    return max(max(body.rest_rate, part * body.top_speed) for body in bodies)


def _look_at_rigid(scene: Scene, lattice: Lattice, counts: np.ndarray) -> None:
    """Refuse rigid bodies that are too thin or overlap others, as in a run."""
    scene.interaction.rigid_bodies.measure(Serial(), keep=True)
    blocks = (
        (block.positions, np.full(len(block.ids), body, np.int32))
        for body in range(len(lattice.bodies))
        for block in lattice.make((0, lattice.planes), counts, body)
    )
    require_apart(scene.interaction.rigid_bodies, blocks, Serial())
    require_clear(
        scene.interaction.rigid_bodies,
        scene.domain.faces,
        scene.interaction.rigid_bodies.first,
        0,
        0.0,
        Serial(),
    )


def _step(scene: Scene, rate: float) -> float:
    """Length of a step; of the first step if steps are controlled."""
    case = scene.case
    if not isinstance(case.time.step, float | int):
        assert case.courant is not None
        return min(
            case.courant / max(rate, scene.interaction.rigid_bodies.first_rate), case.time.end
        )
    require_stable(scene, float(case.time.step), rate)
    return float(case.time.step)
