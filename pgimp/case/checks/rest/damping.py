"""Checks of damping, and of mass scaling."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pgimp.case.body import Body
from pgimp.case.damping import Damping
from pgimp.case.time import Time
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.contact.pairs import ContactEntry
from pgimp.physics.materials.base import Material
from pgimp.physics.rigid import RigidBody
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_damping(
    damping: Damping | None,
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    boundaries: Mapping[str, Boundary],
    contact: Sequence[ContactEntry],
) -> Problems:
    """Check that all that moves is damped, and that local damping knows the whole force.

    Rigid bodies that move freely have no vertices. Local damping takes a part of the force before
    contact: bodies at rest would press on each other with other forces.
    """
    if damping is None:
        return
    free = [name for name, body in rigid_bodies.items() if body.free]
    if free:
        yield Problem(
            ("damping",),
            f"is for bodies of a material, at the vertices of the grid; '{free[0]}' is rigid and "
            "moves freely, and would go on: leave damping out, or give it a motion, rigid: "
            "{velocity: ..}",
        )
    initial = [body.configuration == "initial" for body in bodies.values()]
    lets_go = any(entry.approaches for entry in boundaries.values())
    meets = ""
    if contact:
        meets = "contact"
    elif rigid_bodies:
        meets = f"contact with the rigid body '{next(iter(rigid_bodies))}'"
    elif any(initial) and not all(initial):
        meets = "contact of bodies of both configurations"
    elif any(initial) and lets_go:
        meets = "contact with a separating wall in the initial configuration"
    if damping.local and meets:
        yield Problem(
            ("damping", "local"),
            f"is a part of the force on a vertex before {meets}, so that what is at rest would "
            "press with other forces: take {kinetic: true} or {mass: RATE}",
        )


def check_mass_scaling(
    time: Time,
    materials: Mapping[str, Material],
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    boundaries: Mapping[str, Boundary],
    inflow: Mapping[str, object],
    body_force: object,
    exact: object,
) -> Problems:
    """Check that inertia is of no matter in what is asked for, and may be scaled in all that is."""
    if time.mass_scaling == 1.0:
        return
    path = ("time", "mass-scaling")
    text = "changes inertia, for quasi-static runs: "
    for name, body in bodies.items():
        law = materials.get(body.material)
        if not isinstance(body.velocity, tuple) or any(body.velocity):
            yield Problem(path, f"{text}'{name}' begins with a velocity; leave one of them out")
        if law is not None and not law.INERTIA_ALONE:
            yield Problem(
                path,
                f"{text}the density of '{body.material}' ({getattr(law, 'model', 'a model')}) is "
                "more than inertia; leave this out",
            )
        elif law is not None and ("density",) in law.variations:
            yield Problem(
                path, f"{text}give '{body.material}' one density; layers may be bodies of their own"
            )
    for name, rigid in rigid_bodies.items():
        if rigid.free:
            yield Problem(path, f"{text}'{name}' moves freely, by inertia; give it a motion")
    for face, entry in boundaries.items():
        if entry.absorbs:
            yield Problem(
                path, f"{text}waves that {face} absorbs have another speed; hold the face"
            )
    for what, there in (("inflow", inflow), ("body_force", body_force), ("exact", exact)):
        if there:
            yield Problem(path, f"{text}{what} would not be what it is; leave one of them out")
