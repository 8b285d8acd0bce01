"""Errors of a case that only its particles show: they are made as in a run, and let go."""

import numpy as np

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.initial_stress import set_initial_stress
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.bodies.populate import populate
from pgimp.scene.scene import Scene
from pgimp.solver.start.sound import STRESS, require_light, require_particles, shown_by_particles

#: Most particles that are made, in some 4 seconds.
MAX_PARTICLES = 2_000_000
#: Most particles with a deformation that gives the stress of the start: it is searched for, in some
#: 5 seconds.
MOST_STRESSED = 250_000
#: Most keys named of what is not looked at.
_NAMED = 4


def look_at_particles(scene: Scene, lattice: Lattice, counts: np.ndarray) -> list[str]:
    """Refuse what a run would refuse of its particles; return notes on what is not looked at.

    Raises
    ------
    CaseError
        As at the start of a run.
    """
    keys, count = shown_by_particles(scene), int(counts.sum())
    if not keys:
        return []
    if count > MAX_PARTICLES:
        return [_left_out(keys, MAX_PARTICLES)]
    particles = populate(scene, lattice, counts, (0, lattice.planes))
    count = int(np.count_nonzero(particles.m))
    mass, materials, notes = particles.m[:count], scene.materials, []
    require_particles(scene, particles, count, Serial())
    if scene.case.start.stress is not None:
        if count > MOST_STRESSED and _searches(scene.case):
            notes.append(_left_out([STRESS], MOST_STRESSED))
        else:
            set_initial_stress(scene, particles, count, Serial(), scene.case.start.stress)
    if materials.variations and materials.densest is None:
        materials.weigh(float((mass / particles.V0[:count]).max()))
    require_light(scene, float(mass.sum()))
    return notes


def _left_out(keys: list[str], most: int) -> str:
    more = f" and {len(keys) - _NAMED} more" if len(keys) > _NAMED else ""
    return (
        f"{', '.join(keys[:_NAMED])}{more}: not looked at with more than {most:,} particles; a run "
        "does so before its first step, and check with larger cells (--set grid.cell=..)"
    )


def _searches(case: Case) -> bool:
    """Whether a body has a law that gets its stress by a deformation."""
    laws = (case.materials[body.material] for body in case.bodies.values())
    return not all(law.CARRIES_STRESS and law.CARRIES_PRESSURE for law in laws)
