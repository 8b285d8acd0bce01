"""What a run requires of its particles at the start; ``pgimp check`` looks at the same."""

from pgimp.case.locations import located
from pgimp.errors import CaseError
from pgimp.geometry.regions import Points
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.scene.checks.own_functions import asks, require_sound
from pgimp.scene.scene import Scene

#: Key of the stress at the start.
STRESS = "start.stress"


def shown_by_particles(scene: Scene) -> list[str]:
    """Keys of the case whose errors may show only in its particles."""
    stress = [STRESS] if scene.case.start.stress is not None else []
    loads = [f"tractions.{name}.region" for name in scene.interaction.loads.surfaces.entries]
    files = [
        f"bodies.{name}.region"
        for name, body in scene.case.bodies.items()
        if any(isinstance(part, Points) for part in body.region.simple())
    ]
    return [*asks(scene), *loads, *stress, *files]


def require_particles(scene: Scene, particles: Particles, count: int, comm: Communicator) -> None:
    """Refuse functions without values, and loads that act on no particle; collective.

    Raises
    ------
    CaseError
        On every rank, if there is one among the first `count` particles.
    """
    require_sound(scene, particles, count, comm)
    scene.interaction.loads.require_all_hold(particles, count, comm)
    scene.interaction.loads.surfaces.require(particles, count, comm)


def require_light(scene: Scene, total: float) -> None:
    """Refuse particles that weigh more than the domain can hold: only those from a file can.

    Raises
    ------
    CaseError
        If `total`, the mass of all, is more.
    """
    if total > 2.0 * scene.materials.most_mass:
        with located(scene.case):
            raise CaseError(
                f"bodies: the particles weigh {total:.6g}, and the whole domain, filled with "
                f"the densest material, {scene.materials.most_mass:.6g}; "
                "look at the volumes of points"
            )
