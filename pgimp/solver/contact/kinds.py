"""The kind of contact of a scene; what a scene does not use is not imported."""

from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact


def contact_kind(scene: Scene) -> type[NoContact]:
    """Return the class of a scene's contact."""
    meets = scene.interaction.pairs or scene.domain.unilateral_walls
    if scene.settings.mixed:
        from pgimp.solver.contact.material.mixed import MixedContact

        return MixedContact
    if meets and scene.settings.initial:
        from pgimp.solver.contact.surfaces.contact import SurfaceContact

        return SurfaceContact
    if scene.interaction.pairs:
        from pgimp.solver.contact.multifield import MultifieldContact

        return MultifieldContact
    return NoContact
