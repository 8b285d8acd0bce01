"""What all regions have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from importlib import import_module
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from pgimp.case.dispatch import ByKey

Points = NDArray[np.float64]
Mask = NDArray[np.bool_]
Bounds = tuple[tuple[float, ...], tuple[float, ...]]


class Region(ABC):
    """A part of space. Points on its surface are inside or outside by a fixed rule.

    Whether a point is inside is computed for each point alone, in a fixed order of operations,
    so that the answer does not depend on the other points of the call.
    """

    @abstractmethod
    def contains(self, points: Points) -> Mask:
        """Tell which points lie in the region.

        Parameters
        ----------
        points : ndarray of float64, shape (n, D)
            Positions.

        Returns
        -------
        ndarray of bool, shape (n,)
            Whether each point is inside.
        """

    @abstractmethod
    def bounds(self) -> Bounds:
        """Return the low and the high corner, shape (D,) each, of a box around the region."""


def _registry() -> Mapping[str, type[BaseModel]]:
    return import_module("pgimp.scene.regions").REGIONS


REGION = ByKey(_registry, "region")

RegionEntry = Annotated[Any, REGION]
"""A region as a case writes it, ``{box: {...}}``; validated to a `Region`."""
