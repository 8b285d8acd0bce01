"""Checks of `start.stress`, of the weight above and what it gives each material; and of water."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pgimp.case.body import Body
from pgimp.case.start import JAKY, InitialStress, StartEntry, friction_angle
from pgimp.physics.loads.own_stress import OwnStress
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.loads.water import Water, vertical_of
from pgimp.physics.materials.base import Material
from pgimp.physics.materials.cam_clay import CamClay
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems
from pgimp.schema.tables import VectorFunction

STRESS = ("start", "stress")


def check_geostatic(
    start: StartEntry,
    gravity: object,
    materials: Mapping[str, Material],
    bodies: Mapping[str, Body],
    dimensions: int,
    tractions: Mapping[str, TractionEntry],
) -> Problems:
    """Check that there is a weight along one axis, and that bodies have what its stress needs."""
    if start.stress is None:
        return
    laws = {name: materials.get(body.material) for name, body in bodies.items()}
    if isinstance(start.stress, OwnStress):
        yield from _own(start.stress, dimensions, bodies)
        return
    for i, name in enumerate(start.stress.surcharge):
        if name not in tractions:
            yield Problem((*STRESS, "surcharge", i), unknown("traction", name, tractions))
    pull = gravity.value(0.0) if isinstance(gravity, VectorFunction) else gravity
    parts = pull if isinstance(pull, list | tuple) else ()
    if sum(part != 0.0 for part in parts) != 1:
        yield Problem(
            STRESS,
            "is that of the weight above each particle: gravity has to act along one axis at time "
            "0; of a gravity that leans no column knows where its weight goes: begin without "
            "stress, and settle, or give the stress by a function of your own",
        )
    if isinstance(start.stress.k0, Mapping):
        for name in sorted(set(start.stress.k0) - set(bodies)):
            yield Problem((*STRESS, "k0", name), unknown("body", name, bodies))
    yield from _unfit(start.stress, bodies, laws)
    if start.stress.ocr is not None and not any(isinstance(x, CamClay) for x in laws.values()):
        yield Problem((*STRESS, "ocr"), "is of cam-clay, and no body is of it; leave it out")


def _own(entry: OwnStress, dimensions: int, bodies: Mapping[str, Body]) -> Iterator[Problem]:
    """Yield the problems of a stress by a function of one's own."""
    for found in entry.misfits(dimensions):
        yield found._replace(path=(*STRESS, *found.path))
    for i, name in enumerate(entry.bodies or ()):
        if name not in bodies:
            yield Problem((*STRESS, "bodies", i), unknown("body", name, bodies))


def _unfit(
    entry: InitialStress, bodies: Mapping[str, Body], laws: Mapping[str, Material | None]
) -> Iterator[Problem]:
    """Yield the problems of bodies."""
    for name, law in laws.items():
        if law is None:
            continue
        by_body = isinstance(entry.k0, Mapping)
        value = entry.k0.get(name) if isinstance(entry.k0, Mapping) else entry.k0
        where = (*STRESS, "k0", name) if by_body else (*STRESS, "k0")
        fluid = law.VOLUME_ONLY and not law.CARRIES_STRESS
        if value is None and not fluid:
            yield Problem((*STRESS, "k0"), f"has no entry of '{name}': add one")
        if value == JAKY and friction_angle(law) is None and not fluid:
            yield Problem(
                where,
                f"1-sin-phi needs the friction-angle of a soil, which '{bodies[name].material}' of "
                f"'{name}' has not; give a number, by body: {{{name}: 0.5}}",
            )


def check_water(
    water: Water | None,
    gravity: object,
    materials: Mapping[str, Material],
    bodies: Mapping[str, Body],
) -> Problems:
    """Check that water has a vertical, and fills bodies that are heavier."""
    if water is None:
        return
    if vertical_of(gravity) is None:
        yield Problem(
            ("water",),
            "needs gravity, whose greatest component is the vertical: gravity: [0.0, -9.81]",
        )
    if water.bodies == ():
        yield Problem(("water", "bodies"), "names no body; without the key it fills all")
    for i, name in enumerate(water.bodies or ()):
        if name not in bodies:
            yield Problem(("water", "bodies", i), unknown("body", name, bodies))
    for name, body in bodies.items():
        law = materials.get(body.material)
        if law is None or not water.fills(name) or law.density > water.density:
            continue
        where = ("water",) if water.bodies is None else ("water", "bodies")
        others = [other for other in bodies if other != name and water.fills(other)]
        yield Problem(
            where,
            f"fills the pores of '{name}', whose density with its water, {law.density:g}, has to "
            f"be above that of water, {water.density:g}: take the saturated density of ground; a "
            f"body without pores is left out by bodies: [{', '.join(others)}]",
        )
