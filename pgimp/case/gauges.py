"""Gauges: forces, fluxes and levels of a part of space in the history; entries in the case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, Field

from pgimp.geometry.regions.base import REGION, RegionEntry
from pgimp.schema.base import Model, Name, Positive, Vector
from pgimp.schema.dispatch import Either
from pgimp.schema.registries import ByWord


class Gauge(Model):
    """What all gauges have."""

    bodies: tuple[Name, ...] | None = Field(
        default=None, description="bodies that count; null: all of a material"
    )
    mean: Positive | None = Field(
        default=None,
        description="columns `gauge.NAME.mean` too: means over so much time before a line, of the "
        "lines in it (trapezoidal rule); null: none [time]",
    )


class _Partial(Gauge):
    """A gauge of a part of the material."""

    within: Annotated[Any, Either("a region or null", {dict: REGION, None: None})] = Field(
        default=None,
        description="part of space of which alone the material counts, by its particles' centres; "
        "null: all",
    )


class CutGauge(_Partial):
    """Force and moment through a cut, from stresses."""

    cut: RegionEntry = Field(
        description="half-space or box: the force is that on the material inside by what is "
        "outside; of bodies in the initial configuration it cuts them where they were at the start"
    )
    about: Vector | None = Field(
        default=None,
        description="point of the moment; null: the point of the half-space, the centre of the box "
        "[length]",
    )


class FluxGauge(_Partial):
    """Mass and momentum that pass a surface."""

    flux: RegionEntry = Field(
        description="half-space or box: the flux out of it through its surface, as a mean over a "
        "cell on either side"
    )


class WallGauge(_Partial):
    """Force and pressure on a wall, or on a part of it."""

    wall: str = Field(
        description="face of the domain with a condition, x-min to z-max; with `within` the part "
        "of it that this region's particles press on"
    )


class LevelGauge(Gauge):
    """Height of the material above a place."""

    level: Vector = Field(
        description="the place: x in 2D, [x, y] in 3D; heights are along the last axis [length]"
    )


def flux_gauges(gauges: Mapping[str, Any]) -> dict[str, FluxGauge]:
    """Return the flux gauges of a case by name, in the order of the ledger."""
    return {name: gauge for name, gauge in gauges.items() if isinstance(gauge, FluxGauge)}


GAUGES: Mapping[str, type[BaseModel]] = {
    "cut": CutGauge,
    "flux": FluxGauge,
    "wall": WallGauge,
    "level": LevelGauge,
}

GaugeEntry = Annotated[Any, ByWord(lambda: GAUGES, "gauge")]
"""A gauge as a case writes it, ``{cut: {half-space: ..}}`` or ``{level: [..]}``."""
