"""Warnings of volumetric locking and checkerboards of stress, which ``volumetric`` governs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from pgimp.case.body import has_means
from pgimp.scene.checks.warned import Warned, warned

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.physics.materials.base import Material

#: Most bodies that a message names one by one.
_NAMED = 3

#: Poisson's ratio above which bodies lock.
_NEARLY_HALF = 0.45


def locking(case: Case, poisson: Mapping[str, float] | None = None) -> Iterator[Warned]:
    """Yield a warning for each nearly incompressible solid, which locks: too stiff.

    Parameters
    ----------
    poisson : mapping of str to float, optional
        Greatest Poisson's ratio of bodies where it varies in space.
    """
    found: dict[tuple[str, float], list[str]] = {}
    for body, name, material in _pointwise(case):
        ratio = _ratio(body, material, poisson)
        if ratio > _NEARLY_HALF:
            found.setdefault((name, ratio), []).append(body)
    for (name, ratio), bodies in found.items():
        yield warned(
            "locking",
            f"materials.{name}.poisson: {ratio:g} is nearly incompressible, and {_named(bodies)} "
            "will be too stiff, the more so the closer to 0.5 it is (locking); "
            f"method.volumetric: b-bar keeps it from that{_boxes(case)}",
        )


def locked(case: Case) -> Iterator[tuple[str, float]]:
    """Yield each body with pointwise volumes, and its Poisson's ratio, where that is known."""
    for body, _, material in _pointwise(case):
        if ratio := _ratio(body, material, None):
            yield body, ratio


def stripes(case: Case, poisson: Mapping[str, float] | None = None) -> Iterator[str]:
    """Yield a note for each plastically flowing solid, whose stress shows stripes.

    None for liquids, grains and bodies that `locking` warns of. Parameters as in `locking`.
    """
    found: dict[str, list[str]] = {}
    for body, name, material in _pointwise(case):
        plastic = "plastic-work" in material.LOSSES and not material.VOLUME_ONLY
        if plastic and not _ratio(body, material, poisson) > _NEARLY_HALF:
            found.setdefault(name, []).append(body)
    for name, bodies in found.items():
        flow = "flows" if len(bodies) == 1 else "flow"
        yield (
            f"materials.{name}: {_named(bodies)} {flow} plastically, where particles of one cell "
            "get different pressures (a checkerboard of stress) and too much strength (locking); "
            f"method.volumetric: b-bar keeps it from that{_boxes(case)}"
        )


def _named(bodies: list[str]) -> str:
    """Names of the first bodies, and the number of the others."""
    names = ", ".join(f"'{body}'" for body in bodies[:_NAMED])
    return names + (f" and {len(bodies) - _NAMED} more" if len(bodies) > _NAMED else "")


def _pointwise(case: Case) -> Iterator[tuple[str, str, Material]]:
    """Bodies with pointwise volumes, with their material and its name."""
    method = case.method
    if case.dimensions == 1 or not method.locks:
        return
    for body, entry in case.bodies.items():
        if not has_means(entry, method):
            yield body, entry.material, case.materials[entry.material]


def _ratio(body: str, material: Material, poisson: Mapping[str, float] | None) -> float:
    """Poisson's ratio; 0 if there is none or its maximum is not yet known."""
    ratio = (poisson or {}).get(body, getattr(material, "poisson", 0.0))
    return float(ratio) if isinstance(ratio, float | int) else 0.0


def _boxes(case: Case) -> str:
    return "" if case.method.chi == "box" else ", with boxes (shape: gimp)"
