"""The kind of contact of a scene; what a scene does not use is not imported."""

from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact


def contact_kind(scene: Scene) -> type[NoContact]:
    """Return the class of a scene's contact."""
    meets = scene.interaction.pairs or scene.domain.unilateral_walls
    exact = scene.settings.exact_surfaces.any() and scene.settings.exact_surfaces.all()
    if meets and exact and not (scene.case.axisymmetric or any(scene.domain.periodic)):
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
