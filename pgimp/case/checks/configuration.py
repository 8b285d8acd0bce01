"""Checks of bodies in the current configuration: beside others, and of their mass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

from pgimp.case.body import Body
from pgimp.physics.contact.base import TIED
from pgimp.physics.contact.pairs import ContactEntry, Pairs
from pgimp.physics.rigid import RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_parted(
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    contact: Sequence[ContactEntry],
) -> Problems:
    """Check that bodies in the current configuration beside others either share a field or meet.

    Tied bodies share one field, also with bodies that are tied to these in turn.
    """
    current = [name for name, body in bodies.items() if body.formulation == "updated-lagrangian"]
    if len(current) == len(bodies):
        return
    names = [*bodies, *rigid_bodies]
    if any(not set(entry.bodies) <= set(names) for entry in contact if entry.bodies != "all"):
        return
    pairs = Pairs.of(contact, names)
    root = {name: name for name in current}
    parted = []
    for one, other in combinations(current, 2):
        number = abs(int(pairs.entry[names.index(one), names.index(other)]))
        if number and pairs.kind[number - 1] == TIED:
            old = root[other]
            root = {name: root[one] if end == old else end for name, end in root.items()}
        else:
            parted.append((one, other))
    for one, other in parted:
        if root[one] == root[other]:
            yield Problem(
                ("contact",),
                f"'{one}' and '{other}' have an entry, but both are tied to another body without "
                "one; beside bodies in the initial configuration all of them need an entry: take "
                "{bodies: all}",
            )


def check_averaged(bodies: Mapping[str, Body], method: Shape) -> Problems:
    """Check that bodies with averaged mass are in the initial configuration."""
    for name, body in bodies.items():
        if (body.mass or method.mass) != "averaged" or body.formulation == "total-lagrangian":
            continue
        path = ("bodies", name, "mass") if body.mass else ("method", "mass")
        yield Problem(
            path,
            f"averaged is for the initial configuration, but '{name}' is in the current one, where "
            "weights, and so this mass, would change with every step: take formulation: "
            "total-lagrangian, or mass: lumped for this body",
        )
        return
