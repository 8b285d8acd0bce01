"""Checks of damping."""

from __future__ import annotations

from collections.abc import Mapping

from pgimp.case.damping import Damping
from pgimp.physics.rigid import RigidBody
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_damping(damping: Damping | None, rigid_bodies: Mapping[str, RigidBody]) -> Problems:
    """Check that no rigid body moves freely, whose motion no vertex has."""
    free = [name for name, body in rigid_bodies.items() if body.free]
    if damping is not None and free:
        yield Problem(
            ("damping",),
            f"is for bodies of a material, at the vertices of the grid; '{free[0]}' is rigid and "
            "moves freely, and would go on: leave damping out, or give it a motion, rigid: "
            "{velocity: ..}",
        )
