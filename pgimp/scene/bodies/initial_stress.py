"""The stress with which bodies begin: of the weight above, or of a function of one's own."""

from __future__ import annotations

import numpy as np

from pgimp.case.start import InitialStress
from pgimp.errors import CaseError
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.collective import all_or_none
from pgimp.mpi.communicator import Communicator
from pgimp.physics.loads.own_stress import OwnStress
from pgimp.scene.bodies.geostatic import set_geostatic_stress
from pgimp.scene.bodies.prestrain import every_unknown, find_deformation
from pgimp.scene.scene import Scene


def set_initial_stress(
    scene: Scene,
    particles: Particles,
    count: int,
    comm: Communicator,
    entry: InitialStress | OwnStress,
    time: float = 0.0,
) -> None:
    """Set stress, deformation and states of the first `count` particles; collective.

    Raises
    ------
    CaseError
        On every rank, if a material has no such stress, or bears no tension.
    """
    if isinstance(entry, InitialStress):
        set_geostatic_stress(scene, particles, count, comm, entry, time)

    def set_all() -> None:
        for body, name in enumerate(scene.body_names):
            if name not in scene.case.inflow and entry.begins(name):
                rows = np.flatnonzero(particles.body[:count] == body)
                if isinstance(entry, OwnStress):
                    _set_body(scene, particles, rows, name, entry)
                _require_pressure(scene, particles, rows, name)

    all_or_none(comm, set_all, CaseError)


def _set_body(scene: Scene, p: Particles, rows: np.ndarray, name: str, entry: OwnStress) -> None:
    """Set the stress of a body's particles."""
    law = scene.case.materials[scene.case.bodies[name].material]
    wanted = entry.at(p.x[rows], p.sigma.shape[1])
    if not np.isfinite(wanted).all():
        row = int(np.argmin(np.isfinite(wanted).all(axis=1)))
        place = ", ".join(f"{x:.6g}" for x in p.x[rows[row]])
        numbers = ", ".join(f"{each:g}" for each in wanted[row])
        raise CaseError(f"start.stress: {entry.registered} returns ({numbers}) at ({place})")
    p.sigma[rows] = wanted
    if not (law.CARRIES_STRESS and law.CARRIES_PRESSURE):
        words = str(entry.registered), "take another stress, stiffer material, or settle"
        find_deformation(scene, (p, rows), name, wanted, every_unknown(scene, name), words)


def _require_pressure(scene: Scene, p: Particles, rows: np.ndarray, name: str) -> None:
    """Refuse a mean stress of tension in a material that bears none: its energy is negative."""
    law = scene.case.materials[scene.case.bodies[name].material]
    mean = p.sigma[rows, :3].mean(axis=1)
    if not law.BEARS_TENSION and mean.max(initial=0.0) > 0.0:
        row = int(np.argmax(mean))
        place = ", ".join(f"{x:.6g}" for x in p.x[rows[row]])
        raise CaseError(
            f"start.stress: '{name}' begins with a mean stress of {mean[row]:.3g} at ({place}), "
            f"tension, of which '{law.model}' bears none: it would be gone in the first step; "
            "compression is negative"
        )
