"""Regions of space that bodies fill, one file a kind.

A region is a pydantic model of its entry in the case, and also a `Region`: it has an inside test
for points and a bounding box.
"""

from pgimp.geometry.regions.ball import Ball
from pgimp.geometry.regions.base import REGION, REGIONS, Region, RegionEntry
from pgimp.geometry.regions.box import Box
from pgimp.geometry.regions.combine import Difference, Intersection, Union
from pgimp.geometry.regions.cylinder import Cylinder
from pgimp.geometry.regions.half_space import HalfSpace
from pgimp.geometry.regions.heights import Heights
from pgimp.geometry.regions.mesh import Mesh
from pgimp.geometry.regions.points import Points

REGIONS |= {
    "box": Box,
    "ball": Ball,
    "cylinder": Cylinder,
    "half-space": HalfSpace,
    "mesh": Mesh,
    "heights": Heights,
    "points": Points,
    "union": Union,
    "difference": Difference,
    "intersection": Intersection,
}

__all__ = [
    "REGION",
    "REGIONS",
    "Ball",
    "Box",
    "Cylinder",
    "Difference",
    "HalfSpace",
    "Heights",
    "Intersection",
    "Mesh",
    "Points",
    "Region",
    "RegionEntry",
    "Union",
]
