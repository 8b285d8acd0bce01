"""Whether bodies of a case would lock, or have stripes of stress: a matter of ``volumetric``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Poisson's ratio above which bodies lock.
_NEARLY_HALF = 0.45


def locking(case: Case, poisson: Mapping[str, float] | None = None) -> Iterator[str]:
    """Yield a warning about each solid that is nearly incompressible, and so too stiff.

    Parameters
    ----------
    case : Case
        The case.
    poisson : mapping of str to float, optional
        The greatest Poisson's ratio of bodies whose own varies in space.
    """
    for body, name, material in _pointwise(case):
        ratio = _ratio(body, material, poisson)
        if ratio > _NEARLY_HALF:
            yield (
                f"materials.{name}.poisson: {ratio:g} is nearly incompressible, and '{body}' "
                "will be too stiff, the more so the closer to 0.5 it is (locking); "
                f"method.volumetric: mean keeps it from that{_boxes(case)}"
            )


def stripes(case: Case, poisson: Mapping[str, float] | None = None) -> Iterator[str]:
    """Yield a note about each solid that flows plastically, so that its stress has stripes.

    Liquids and grains have none, nor what `locking` warns of. Parameters are those of `locking`.
    """
    for body, name, material in _pointwise(case):
        plastic = "plastic-work" in material.LOSSES and not material.VOLUME_ONLY
        if plastic and not _ratio(body, material, poisson) > _NEARLY_HALF:
            yield (
                f"materials.{name}: '{body}' flows plastically, where particles of one cell get "
                "different pressures (stripes of stress) and too much strength (locking); "
                f"method.volumetric: mean keeps it from that{_boxes(case)}"
            )


def _pointwise(case: Case) -> Iterator[tuple[str, str, Any]]:
    """Bodies, with their material and its name, where particles have each their own volume."""
    method = case.method
    if case.dimensions == 1 or method.volumetric == "mean" or method.shape == "fuzzy-constant":
        return
    for body, entry in case.bodies.items():
        yield body, entry.material, case.materials[entry.material]


def _ratio(body: str, material: Any, poisson: Mapping[str, float] | None) -> float:
    """Poisson's ratio; 0 where there is none, or the greatest is not known yet."""
    ratio = (poisson or {}).get(body, getattr(material, "poisson", 0.0))
    return float(ratio) if isinstance(ratio, float | int) else 0.0


def _boxes(case: Case) -> str:
    return "" if case.method.chi == "box" else ", with boxes (shape: gimp)"
