"""Regions of space that bodies fill, one file a kind.

A region is a pydantic model of its entry in the case that is also a `Region`: it tells which
points lie inside, and a box around it.
"""

from pydantic import BaseModel

from pgimp.scene.regions.ball import Ball
from pgimp.scene.regions.base import REGION, Region, RegionEntry
from pgimp.scene.regions.box import Box
from pgimp.scene.regions.combine import Difference, Intersection, Union
from pgimp.scene.regions.cylinder import Cylinder
from pgimp.scene.regions.half_space import HalfSpace
from pgimp.scene.regions.mesh import Mesh
from pgimp.scene.regions.points import Points

REGIONS: dict[str, type[BaseModel]] = {
    "box": Box,
    "ball": Ball,
    "cylinder": Cylinder,
    "half-space": HalfSpace,
    "mesh": Mesh,
    "points": Points,
    "union": Union,
    "difference": Difference,
    "intersection": Intersection,
}
"""The regions by their name in the case, ``region: {NAME: ...}``."""

__all__ = [
    "REGION",
    "REGIONS",
    "Ball",
    "Box",
    "Cylinder",
    "Difference",
    "HalfSpace",
    "Intersection",
    "Mesh",
    "Points",
    "Region",
    "RegionEntry",
    "Union",
]
