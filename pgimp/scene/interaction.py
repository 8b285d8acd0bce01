"""Interaction of the bodies of a scene: loads, rigid bodies, contact pairs, flowing bodies."""

import numpy as np

from pgimp.case.checks.rigid_bodies import meet_by_surfaces
from pgimp.case.schema import Case
from pgimp.physics.contact.base import UNILATERAL
from pgimp.physics.contact.pairs import Pairs
from pgimp.scene.domain import Domain
from pgimp.scene.flows import SceneFlows
from pgimp.scene.loads import SceneLoads
from pgimp.scene.materials import MaterialTable
from pgimp.scene.rigid.rigid import SceneRigidBodies
from pgimp.scene.settings import Settings
from pgimp.scene.water import SceneWater


class Interaction:
    """Forces on bodies and between them.

    Attributes
    ----------
    loads : SceneLoads
        Viscosity, tractions, constraints and the body force.
    rigid_bodies : SceneRigidBodies
        The rigid bodies; false if there are none.
    pairs : Pairs or None
        Contact laws; None where all bodies share one velocity field.
    flows : SceneFlows or None
        The flowing bodies, if there are any.
    """

    def __init__(
        self, case: Case, settings: Settings, domain: Domain, materials: MaterialTable
    ) -> None:
        force = settings.exact if case.exact and case.exact.forced else ()
        if case.body_force:
            force = case.body_force.parameters()
        current = ~settings.lagrangian
        water = SceneWater(case, materials) if case.water else None
        self.loads = SceneLoads(
            case,
            materials.names,
            (force, water),
            domain.sides_approached,
            case.method.follows & current,
        )
        self.rigid_bodies = SceneRigidBodies(case, domain.frame, domain.periods)
        self.pairs: Pairs | None = None
        if case.contact or self.rigid_bodies or settings.mixed:
            self.pairs = Pairs.of(case.contact, [*case.bodies, *self.rigid_bodies.names])
        if self.pairs and meet_by_surfaces(case.bodies):
            self.rigid_bodies.meeting = self._rigid_pairs(case)
            self.rigid_bodies.meets_walls = True
        of_body = np.array(materials.body_material, np.int64)
        flows = SceneFlows(case, materials.entries, of_body, current, domain.faces, self.pairs)
        self.flows = flows if flows.rates.any() else None

    def _rigid_pairs(self, case: Case) -> frozenset[frozenset[int]]:
        """Pairs of rigid bodies with an entry of contact, one of them free."""
        assert self.pairs
        n, own = len(case.bodies), [*case.rigid_bodies.values()]
        entry = np.abs(self.pairs.entry[n:, n:])
        acts = np.triu((0 < entry) & (entry <= len(case.contact)), 1)
        acts &= self.pairs.kind[entry - 1] == UNILATERAL
        return frozenset(
            frozenset(pair)
            for pair in np.argwhere(acts).tolist()
            if any(own[number].free for number in pair)
        )
