"""Columns of the particles: how one is declared, and which a scene carries."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from pgimp.kernels.data.frame import identity


class Carried(NamedTuple):
    """Columns of a scene's particles.

    Attributes
    ----------
    dimensions : int
        1, 2 or 3.
    origin, affine, viscous : bool
        Whether they keep their initial position, velocity gradient, viscous pressure.
    tractions, state : int
        Number of tractions, and greatest number of state variables of a material.
    surfaces : bool
        Whether they have the cut-off parts at surfaces, for contact.
    mean : bool
        Whether they have their degree of isolation, for mean dilatation.
    cell_F : bool
        Whether they have their cells' deformation gradient, for mean dilatation in the initial
        configuration.
    own : int
        Number of parameters of its material that vary.
    liquid : bool
        Whether they have the gradient of J.
    axial, plate : bool
        Whether they are rings, or parts of a plate: F has a zz, out of the plane.
    surfaces_loaded : int
        Number of loads on parts of surfaces.
    follows_surfaces : bool
        Whether such loads follow the positions.
    products : int
        Number of a part's products of inertia, of bodies that are exact to their surface.
    needed : set of str
        Columns that the case needs by their own declaration, see `Column.needed`.
    """

    dimensions: int
    origin: bool = False
    affine: bool = False
    viscous: bool = False
    tractions: int = 0
    state: int = 0
    surfaces: bool = False
    mean: bool = False
    cell_F: bool = False
    own: int = 0
    liquid: bool = False
    axial: bool = False
    plate: bool = False
    surfaces_loaded: int = 0
    follows_surfaces: bool = False
    products: int = 0
    needed: frozenset[str] = frozenset()

    @property
    def undeformed(self) -> tuple[float, ...]:
        """F of an undeformed particle."""
        return identity(self.dimensions, self.axial or self.plate)


class Column(NamedTuple):
    """A column of the particles, (c,) or (c, k) with the capacity c.

    All migrate, are sorted, checkpointed and resumed; `pgimp.physics.fields` has the columns for
    output.

    Attributes
    ----------
    meaning, unit : str
    width : callable, optional
        k, from `Carried`; 0: the scene does not use it. None: one number, (c,).
    needed : callable, optional
        Whether a case needs it, from the case; else it has the width 0. A column that says so
        needs no entry of its own in `Carried`.
    dtype : type
    least : float, optional
        Least allowed value.
    above : float, optional
        Excluded lower bound of the values.
    numbers : str
        Object that it numbers, if any: from 0 on, or from 1 on where 0 stands for none.
    continued : {"", "optional", "required"}
        Whether a body that goes on from a run's own checkpoint takes it from there, and whether
        that must have it. Otherwise it begins as in a new body.
    initial : float or callable
        Initial value; of a matrix its diagonal, the rest is 0. Or from the particles, which have
        their positions and bodies, and from the bodies' entries in the case: (n,) or (n, k).
    """

    meaning: str
    unit: str = ""
    width: Callable[[Carried], int] | None = None
    dtype: type = np.float64
    least: float | None = None
    above: float | None = None
    numbers: str = ""
    initial: float | Callable[[Any, Sequence[Any]], np.ndarray] = 0.0
    needed: Callable[[Any], bool] | None = None
    continued: Literal["", "optional", "required"] = ""
