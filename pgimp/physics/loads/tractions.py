"""Surface tractions (18): their entries in the case, and the particles that carry them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from pgimp.geometry.regions.base import REGION
from pgimp.physics.loads.surfaces import Hydrostatic, Normal, ProfileEntry, SurfaceLoad
from pgimp.schema.base import Model, Name
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.tables import MayVary, VaryingVector, VectorFunction
from pgimp.schema.time_functions import TimeFunction

#: Part of a column's area below which it is rounding, or negative after merging a small part.
_ROUNDING = 1e-9


def overlaps(width: float, spacing: float) -> int:
    """Number of particle columns from the inner end of one chi_p to the outer end of another.

    Parameters
    ----------
    width, spacing : float
        Width over which chi_p falls from one to zero, half a tent or a box; width of a column.
    """
    return max(1, round(width / spacing))


class Traction(NamedTuple):
    """One traction during one step."""

    #: axis, side: The box's face: its normal in the initial state is `side` times the unit vector
    #: `axis`.
    axis: int
    side: int
    column: int  #: Column of ``particles.patch`` with the patches' areas.
    #: Distance of a patch's centre from its particle's along the axis, in the initial state.
    reach: float
    #: Half-widths of a patch by direction in the initial state: along the axis a box's half-width,
    #: across it chi_p's; zeros for points.
    half: tuple[float, ...]
    tents: bool  #: Whether chi_p, and so the patch across the axis, is a tent and not a box.
    ends: bool  #: Whether weights are means over the ends of a box, not over all of it.
    #: Whether patches follow the deformation gradient, as the particles of the shape do.
    follows: bool
    traction: tuple[float, float, float]  #: Force per current area.
    pressure: float  #: Force per current area against the current normal.


class Spread(NamedTuple):
    """How the characteristic functions chi_p of a scene's particles are spread."""

    #: spacing, half: (D,) float64: Distance of the particles, and the half-widths of chi_p, in the
    #: initial state.
    spacing: np.ndarray
    half: np.ndarray
    chi: str  #: Kind of chi_p.
    ends: bool  #: See `Traction`.


class TractionEntry(Model):
    """A force on a face of a body that fills a box, or on any part of a body's surface."""

    body: Name = Field(description="name of the body; with `face` its region is a box")
    face: str | None = Field(
        default=None, description="face of its box, x-min to z-max; null: see `region`"
    )
    region: Annotated[Any, Either("a region or null", {dict: REGION, None: None})] = Field(
        default=None,
        description="in place of `face` a part of space: the load is on the surface of the body "
        "that lies in it at the start, whatever the body's region is",
    )
    traction: VaryingVector = Field(
        default=None,
        description="force per current area: a vector, or a table over time, linear in between "
        "and held at both ends [stress]",
    )
    pressure: MayVary = Field(
        default=None,
        description="force per current area against the face's current normal: positive pushes "
        "into the body; a number or a table over time [stress]",
    )

    hydrostatic: Hydrostatic | None = Field(
        default=None,
        description="with `region`, in place of a pressure that of a liquid, which gravity gives",
    )
    follower: bool = Field(
        default=True,
        description="with `region`: whether areas and normals are the current ones; false: the "
        "initial ones, so that the force keeps direction and size",
    )
    profile: ProfileEntry | None = Field(
        default=None,
        description="with `region`: the size along a line, which may move; null: the same "
        "everywhere",
    )

    normal: Normal | None = Field(
        default=None,
        description="with `region`: only where the surface's normal at the start is near a "
        "direction, so that the top of a block is its top; null: any",
    )

    @model_validator(mode="after")
    def _check_kind(self) -> TractionEntry:
        given, found = [self.traction, self.pressure, self.hydrostatic], []
        if sum(each is not None for each in given) != 1:
            text = "expected one of traction, pressure and hydrostatic"
            found.append(Problem(("traction",), text))
        if (self.face is None) == (self.region is None):
            found.append(Problem(("face",), "expected either a face of a box or a region"))
        elif self.region is None:
            if self.hydrostatic is not None:
                found.append(Problem(("hydrostatic",), "is for a load with a `region`"))
            if not self.follower:
                text = "is for a load with a `region`; on a face loads follow the deformation"
                found.append(Problem(("follower",), text))
            if self.normal is not None:
                found.append(Problem(("normal",), "is for a load with a `region`"))
            if self.profile is not None:
                text = "is for a load with a `region`: region: {box: ..} in place of face"
                found.append(Problem(("profile",), text))
        if self.hydrostatic is not None and self.profile is not None:
            text = "the pressure of a liquid varies by itself; take `pressure` with a profile"
            found.append(Problem(("profile",), text))
        if self.hydrostatic is not None and not self.follower:
            text = "the pressure of a liquid follows the surface: leave false out"
            found.append(Problem(("follower",), text))
        raise_problems("traction", found)
        return self

    @property
    def varies(self) -> bool:
        """Whether the parameters depend on time."""
        own = self.traction, self.pressure
        return isinstance(own[0], VectorFunction) or isinstance(own[1], TimeFunction)

    @property
    def axis(self) -> int:
        """Direction of the face's normal."""
        assert self.face is not None
        return "xyz".index(self.face[0])

    @property
    def side(self) -> int:
        """End along the axis: -1 or 1."""
        assert self.face is not None
        return -1 if self.face.endswith("min") else 1

    def surface_load(
        self,
        column: int,
        half: tuple[float, ...],
        stretches: bool,
        gravity: Sequence[float],
        t: float,
    ) -> SurfaceLoad:
        """Parameters of the kernels for a load on a region's surface; see `SurfaceLoad`."""
        pressure, vector = self._values(t)
        gradient = (0.0, 0.0, 0.0)
        if self.hydrostatic is not None:
            pressure, gradient = self.hydrostatic.pressure(gravity, t)
        return SurfaceLoad(column, half, self.follower, stretches, vector, pressure, gradient)

    def _values(self, t: float) -> tuple[float, tuple[float, float, float]]:
        """Pressure and traction at time `t`."""
        q, b = self.pressure, self.traction
        pressure = 0.0 if q is None else q.value(t) if isinstance(q, TimeFunction) else float(q)
        vector = () if b is None else b.value(t) if isinstance(b, VectorFunction) else b
        x, y, z = (*(float(c) for c in vector), 0.0, 0.0, 0.0)[:3]
        return pressure, (x, y, z)

    def parameters(self, column: int, spread: Spread, follows: bool, t: float) -> Traction:
        """Parameters of the kernels.

        Parameters
        ----------
        column : int
            See `Traction`.
        spread : Spread
            Of the particles.
        follows : bool
            Whether the size of chi_p follows the deformation.
        """
        pressure, vector = self._values(t)
        chi, wide = spread.chi, [0.0 if spread.chi == "point" else float(h) for h in spread.half]
        # A sum of tents falls from one to zero between a particle's centre and its outer end.
        # A sum of boxes falls at once, or in steps at the outer ends of overlapping boxes.
        gap = float(spread.spacing[self.axis])
        boxes = 0.5 * overlaps(2.0 * wide[self.axis], gap) * gap
        reach = {"point": 0.0, "box": boxes}.get(chi, 0.5 * wide[self.axis])
        wide[self.axis] = reach if chi == "tent" else 0.0
        patch = column, reach, tuple(wide), chi == "tent"
        return Traction(self.axis, self.side, *patch, spread.ends, follows, vector, pressure)

    def areas(
        self, parts: list[np.ndarray], columns: list[np.ndarray], spacing: np.ndarray, overlap: int
    ) -> np.ndarray:
        """Areas of the particles' patches of the face, zero without a patch.

        Parameters
        ----------
        parts : list of (columns,) float64
            By direction, the fraction of each of the lattice's columns that the box covers.
        columns : list of (n,) int64
            By direction, the particles' columns.
        spacing : (D,) float64
            Distance of the particles.
        overlap : int
            See `overlaps`.
        """
        area = np.ones(len(columns[0]))
        for d, (part, column) in enumerate(zip(parts, columns, strict=True)):
            if d != self.axis:
                area *= part[column] * spacing[d]
        inside = np.flatnonzero(parts[self.axis])
        first, last = int(inside[0]), int(inside[-1])
        part = parts[self.axis][first : last + 1][:: self.side].copy()
        if len(part) > 1:
            part[0] = 1.0  # belongs to the other face
        share = part / overlap
        share[:-overlap] -= part[overlap:] / overlap
        share[share < _ROUNDING] = 0.0
        shares = np.zeros_like(parts[self.axis])
        shares[first : last + 1] = share[:: self.side]
        return area * shares[columns[self.axis]]

    def area(self, box: Any) -> float:
        """Area of the face."""
        sides = [high - low for low, high in zip(box.min, box.max, strict=True)]
        return float(np.prod([s for d, s in enumerate(sides) if d != self.axis]))

    def area_of_ring(self, box: Any) -> float | None:
        """Area of the face round the axis; None if it depends on the boxes' outer sides."""
        if self.axis == 0:
            return None
        return float(np.pi * (box.max[0] ** 2 - box.min[0] ** 2))
