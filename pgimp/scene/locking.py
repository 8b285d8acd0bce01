"""Whether bodies of a case would lock, or have stripes of stress: a matter of ``volumetric``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

#: Poisson's ratio above which bodies lock.
_NEARLY_HALF = 0.45


def locking(case: Any, poisson: Mapping[str, float] | None = None) -> Iterator[str]:
    """Yield a warning about each solid whose volume flow or stiffness constrains.

    That is nearly incompressible ones, which are too stiff, and those that flow plastically: there
    the stress of neighbours in a cell differs, in stripes. Liquids and grains have no such advice.

    Parameters
    ----------
    case : Case
        The case.
    poisson : mapping of str to float, optional
        The greatest Poisson's ratio of bodies whose own varies in space.
    """
    method = case.method
    if case.dimensions == 1 or method.volumetric == "mean" or method.shape == "fuzzy-constant":
        return
    boxes = "" if method.chi == "box" else ", with boxes (shape: gimp)"
    for body, entry in case.bodies.items():
        material = case.materials[entry.material]
        ratio = (poisson or {}).get(body, getattr(material, "poisson", 0.0))
        if isinstance(ratio, float | int) and ratio > _NEARLY_HALF:
            yield (
                f"materials.{entry.material}.poisson: {ratio:g} is nearly incompressible, and "
                f"'{body}' will be too stiff, the more so the closer to 0.5 it is (locking); "
                f"method.volumetric: mean keeps it from that{boxes}"
            )
        elif "plastic-work" in material.LOSSES and not material.VOLUME_ONLY:
            yield (
                f"materials.{entry.material}: '{body}' flows plastically, where particles of one "
                "cell get different pressures (stripes of stress) and too much strength (locking); "
                f"method.volumetric: mean keeps it from that{boxes}"
            )
