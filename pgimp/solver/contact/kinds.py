"""The kind of contact of a scene; what a scene does not use is not imported."""

from pgimp.case.checks.rigid_bodies import meet_by_surfaces
from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact


def contact_kind(scene: Scene) -> type[NoContact]:
    """Return the class of a scene's contact."""
    meets = scene.interaction.pairs or scene.domain.unilateral_walls
    case = scene.case
    by_surfaces = meet_by_surfaces(case.bodies, case.method, case.geometry, case.boundaries)
    if by_surfaces and scene.settings.mixed:
        from pgimp.solver.contact.surfaces.beside import MixedContact

        return MixedContact
    if meets and by_surfaces:
        from pgimp.solver.contact.surfaces.contact import SurfaceContact

        return SurfaceContact
    if scene.settings.mixed or (
        scene.settings.initial and (scene.interaction.pairs or scene.domain.unilateral_walls)
    ):
        from pgimp.solver.contact.lagrangian.lagrangian import LagrangianContact

        return LagrangianContact
    if scene.interaction.pairs:
        from pgimp.solver.contact.multifield import MultifieldContact

        return MultifieldContact
    return NoContact
