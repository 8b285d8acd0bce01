"""The kind of contact of a scene."""

from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact
from pgimp.solver.contact.lagrangian.lagrangian import LagrangianContact
from pgimp.solver.contact.multifield import MultifieldContact


def contact_kind(scene: Scene) -> type[NoContact]:
    """Return the class of a scene's contact."""
    if scene.settings.mixed or (
        scene.settings.initial and (scene.interaction.pairs or scene.domain.unilateral_walls)
    ):
        return LagrangianContact
    return MultifieldContact if scene.interaction.pairs else NoContact
