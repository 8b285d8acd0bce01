"""Checks of bodies in the initial configuration: allowed combinations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

from pgimp.case.body import Body
from pgimp.case.output import Output
from pgimp.geometry.regions.points import Points
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.contact.base import TIED
from pgimp.physics.contact.pairs import ContactEntry, Pairs
from pgimp.physics.materials.base import Material
from pgimp.physics.rigid import RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_initial_output(bodies: Mapping[str, Body], output: Output) -> Problems:
    """Check that frames of the initial grid have no forces of contact, which act elsewhere."""
    initial = [name for name, body in bodies.items() if body.configuration == "initial"]
    if initial and "contact" in output.grid:
        yield Problem(
            ("output", "grid", output.grid.index("contact")),
            f"forces of contact act where bodies are, and frames show the grid of the start, as "
            f"'{initial[0]}' is in the initial configuration; the history has their sums",
        )


def check_configuration(
    method: Shape,
    materials: Mapping[str, Material],
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    boundaries: Mapping[str, Boundary],
    escape: Mapping[str, object],
    contact: Sequence[ContactEntry],
    exact: object,
) -> Problems:
    """Check that a case suits the bodies that are in the initial configuration."""
    initial = [name for name, body in bodies.items() if body.configuration == "initial"]
    if not initial:
        return
    first = initial[0]
    current = [name for name in bodies if name not in initial]
    yield from _parted(bodies, rigid_bodies, current, contact)
    on_lattice = [name for name in initial if not isinstance(bodies[name].region, Points)]
    once = list(method.particles_per_cell).count(1)
    if on_lattice and once > 1:
        yield Problem(
            ("method", "particles_per_cell"),
            f"bodies in the initial configuration, as '{on_lattice[0]}', have hourglass modes with "
            f"one particle along {once} directions of a cell: they strain no particle, and grow "
            "without end; take 2 along all directions, or all but one",
        )
    if exact is not None and current:
        yield Problem(
            ("exact",),
            f"is for bodies of one configuration, but '{first}' is initial and '{current[0]}' "
            "current",
        )
    for name in initial:
        law = materials.get(bodies[name].material)
        if law is not None and law.VOLUME_ONLY:
            yield Problem(
                ("bodies", name, "configuration"),
                f"'{bodies[name].material}' flows, and keeps no deformation; the initial "
                "configuration is for solids: take current",
            )
    if current and not method.separable:
        yield Problem(
            ("method", "shape"),
            f"{method.name} is for bodies of one configuration, but '{first}' is initial and "
            f"'{current[0]}' current: take cpdi",
        )
    for face, entry in boundaries.items():
        if (entry.approaches or entry.releases) and not hasattr(entry, "friction"):
            yield Problem(
                ("boundaries", face),
                f"holds what comes against it; of bodies in the initial configuration, as "
                f"'{first}', only separating does: take that, fixed, slip or {{velocity: ..}}, or "
                "configuration: current",
            )
    for face in escape if not current else ():
        yield Problem(
            ("escape", face),
            f"bodies in the initial configuration, as '{first}', may leave the domain, and stay "
            "what they are; leave it out",
        )
    if not method.tracked:
        yield Problem(
            ("method", "volume"),
            f"is for the current configuration; in the initial one, as of '{first}', forces are "
            "computed from the initial volume and the first Piola-Kirchhoff stress, exactly: leave "
            "it out",
        )


def _parted(
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    current: Sequence[str],
    contact: Sequence[ContactEntry],
) -> Problems:
    """Check that bodies in the current configuration beside others either share a field or meet.

    Tied bodies share one field, also with bodies that are tied to these in turn.
    """
    names = [*bodies, *rigid_bodies]
    if any(not set(entry.bodies) <= set(names) for entry in contact if entry.bodies != "all"):
        return
    pairs = Pairs.of(contact, names)
    root = {name: name for name in current}
    parted = []
    for one, other in combinations(current, 2):
        number = abs(int(pairs.entry[names.index(one), names.index(other)]))
        if number and pairs.way[number - 1] == TIED:
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
