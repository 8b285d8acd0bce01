"""Columns of the particles: how one is declared, and which a scene carries."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from pgimp.kernels.data.frame import identity


class Carried(NamedTuple):
    """Columns of a scene's particles."""

    dimensions: int  #: 1, 2 or 3.
    #: origin, affine, viscous: Whether they keep their initial position, velocity gradient, viscous
    #: pressure.
    origin: bool = False
    affine: bool = False
    viscous: bool = False
    #: tractions, state: Number of tractions, and greatest number of state variables of a material.
    tractions: int = 0
    state: int = 0
    surfaces: bool = False  #: Whether they have the cut-off parts at surfaces, for contact.
    mean: bool = False  #: Whether they have their degree of isolation, for mean dilatation.
    #: Whether they have their cells' deformation gradient, for mean dilatation in the initial
    #: configuration.
    cell_F: bool = False
    own: int = 0  #: Number of parameters of its material that vary.
    liquid: bool = False  #: Whether they have the gradient of J.
    #: axial, plate: Whether they are rings, or parts of a plate: F has a zz, out of the plane.
    axial: bool = False
    plate: bool = False
    surfaces_loaded: int = 0  #: Number of loads on parts of surfaces.
    follows_surfaces: bool = False  #: Whether such loads follow the positions.
    #: Number of a part's products of inertia, of bodies that are exact to their surface.
    products: int = 0
    #: Columns that the case needs by their own declaration, see `Column.needed`.
    needed: frozenset[str] = frozenset()

    @property
    def bearing(self) -> int:
        """Number of products of inertia of a part of a loaded surface, see `Particles.bearing`."""
        products = 1 if self.axial and self.products else self.products
        return products * (1 + self.dimensions)

    @property
    def undeformed(self) -> tuple[float, ...]:
        """F of an undeformed particle."""
        return identity(self.dimensions, self.axial or self.plate)


class Column(NamedTuple):
    """A column of the particles, (c,) or (c, k) with the capacity c.

    All migrate, are sorted, checkpointed and resumed; `pgimp.physics.fields` has the columns for
    output.
    """

    meaning: str
    unit: str = ""
    #: k, from `Carried`; 0: the scene does not use it. None: one number, (c,).
    width: Callable[[Carried], int] | None = None
    dtype: type = np.float64
    least: float | None = None  #: Least allowed value.
    above: float | None = None  #: Excluded lower bound of the values.
    #: Object that it numbers, if any: from 0 on, or from 1 on where 0 stands for none.
    numbers: str = ""
    #: Initial value; of a matrix its diagonal, the rest is 0. Or from the particles, which have
    #: their positions and bodies, and from the bodies' entries in the case: (n,) or (n, k).
    initial: float | Callable[[Any, Sequence[Any]], np.ndarray] = 0.0
    #: Whether a case needs it, from the case; else it has the width 0. A column that says so needs
    #: no entry of its own in `Carried`.
    needed: Callable[[Any], bool] | None = None
    #: {"", "optional", "required"}: Whether a body that goes on from a run's own checkpoint takes
    #: it from there, and whether that must have it. Otherwise it begins as in a new body.
    continued: Literal["", "optional", "required"] = ""
