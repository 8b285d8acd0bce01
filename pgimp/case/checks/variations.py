"""Checks of parameters of materials that vary in space."""

from __future__ import annotations

from collections.abc import Mapping

from pgimp.case.body import Body
from pgimp.geometry.regions import Points
from pgimp.physics.materials.base import Material
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems

#: Columns that every file of particles has.
_TAKEN = ("x", "y", "z", "position", "volume", "velocity", "stress", "velocity-gradient")


def check_variations(
    dimensions: int, materials: Mapping[str, Material], bodies: Mapping[str, Body]
) -> Problems:
    """Check that variations fit the dimensions, and that columns belong to files of particles."""
    for name, material in materials.items():
        for keys, variation in material.variations.items():
            path: tuple[str | int, ...] = ("materials", name, *keys)
            for found in variation.problems(dimensions):
                yield found._replace(path=(*path, *found.path))
            columns = [column for part in variation.parts() for column in part.columns]
            for column in columns:
                if column in _TAKEN:
                    text = f"the column '{column}' of particles has a meaning of its own"
                    yield Problem(path, text)
            yield from _not_from_file(path, name, columns, bodies)


def _not_from_file(
    path: tuple[str | int, ...], material: str, columns: list[str], bodies: Mapping[str, Body]
) -> Problems:
    for body, entry in bodies.items():
        if columns and entry.material == material and not isinstance(entry.region, Points):
            yield Problem(
                path,
                f"the column '{columns[0]}' is one of a file of particles, but the body '{body}' "
                "has none: region: {points: {file: ..}}",
            )
