"""Position of the grid, and of the part that a rank stores."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.kernels.data.record import RECORD


class Frame(NamedTuple):
    """Position of the grid. Vertex and layer numbers count from the first ghost vertex.

    All tuples have D entries; vertex number i of direction d has the coordinate
    ``origin[d] + (i - ghost) * cell[d]``.
    """

    origin: tuple[float, ...]
    cell: tuple[float, ...]
    inverse: tuple[float, ...]
    cells: tuple[int, ...]
    ghost: int

    @property
    def vertices(self) -> tuple[int, ...]:
        """Number of vertices of each direction, with `ghost` more beyond either face."""
        return tuple(n + 1 + 2 * self.ghost for n in self.cells)


def identity(dimensions: int, stretches: bool) -> tuple[float, ...]:
    """Return the matrix 1, row by row; with its zz if what is out of the plane `stretches`."""
    plane = tuple(float(i == j) for i in range(dimensions) for j in range(dimensions))
    return (*plane, 1.0) if stretches else plane


def volume_ratio(F: np.ndarray, dimensions: int) -> np.ndarray:
    """Return det(F) of deformation gradients, (..., D*D) or with zz (..., 5)."""
    own = dimensions**2
    plane = F[..., :own].reshape(*F.shape[:-1], dimensions, dimensions)
    return np.asarray(np.linalg.det(plane) * F[..., own:].prod(axis=-1))


class InitialFrame(Frame):
    """Position of a grid of the initial configuration (total Lagrangian).

    In kernels that get it, in a `KernelScene`, weights are taken at the particles' initial
    positions, with gradients by these. Forces come from the first Piola-Kirchhoff stress, and
    particles keep their layer. Kernels choose by its type, so that other scenes are compiled as
    without it.
    """

    __slots__ = ()


class AxialFrame(Frame):
    """Position of the grid of an axisymmetric scene: x is the radius, from the axis at x = 0.

    Vertices and particles stand for rings about the axis. Kernels choose by its type.
    """

    __slots__ = ()


class AxialInitialFrame(Frame):
    """Position of a grid of the initial configuration of an axisymmetric scene."""

    __slots__ = ()


class PlateFrame(Frame):
    """Position of the grid of a scene in plane stress.

    Particles are parts of a plate, free to grow thicker and thinner. Kernels choose by its type.
    """

    __slots__ = ()


class PlateInitialFrame(Frame):
    """Position of a grid of the initial configuration of a scene in plane stress."""

    __slots__ = ()


#: Frames of both configurations by the geometry of a case.
FRAMES: dict[str, tuple[type[Frame], type[Frame]]] = {
    "plane-strain": (Frame, InitialFrame),
    "plane-stress": (PlateFrame, PlateInitialFrame),
    "axisymmetric": (AxialFrame, AxialInitialFrame),
}


class MixedFrame(NamedTuple):
    """Position of the grid for bodies of both configurations, for the canonical order."""

    #: origin, cell, inverse, cells, ghost: See `Frame`.
    origin: tuple[float, ...]
    cell: tuple[float, ...]
    inverse: tuple[float, ...]
    cells: tuple[int, ...]
    ghost: int
    lagrangian: np.ndarray  #: (bodies,) bool: Mask of the bodies in the initial configuration.

    @property
    def vertices(self) -> tuple[int, ...]:
        """See `Frame.vertices`."""
        return Frame(*self[:5]).vertices


class MixedExactFrame(MixedFrame):
    """`MixedFrame` where bodies in the initial configuration are exact to their surface.

    Their particles have the weights of parts of a cell, whose half-widths are zero.
    """

    __slots__ = ()


class MixedAxialFrame(MixedFrame):
    """`MixedFrame` of an axisymmetric scene."""

    __slots__ = ()


class MixedExactAxialFrame(MixedExactFrame):
    """`MixedExactFrame` of an axisymmetric scene."""

    __slots__ = ()


def mixed_frame(frame: Frame, lagrangian: np.ndarray, exact: bool) -> MixedFrame:
    """The grid of a frame for bodies of both configurations.

    Parameters
    ----------
    lagrangian : (bodies,) bool
        Mask of the bodies in the initial configuration.
    exact : bool
        Whether these are exact to their surface.
    """
    kind = MixedExactFrame if exact else MixedFrame
    if isinstance(frame, AxialFrame):
        kind = MixedExactAxialFrame if exact else MixedAxialFrame
    return kind(*frame, lagrangian)


class Window(NamedTuple):
    """The part of the grid that a rank stores: its planes, reduced to the range of the particles.

    `lower` is the first vertex of each of three directions, `extent` the number of vertices (1
    along missing directions). `stride` is the distance of neighbours in float64.

    With several velocity fields, the fields of a plane follow each other. `bodies`, (bodies,)
    int64, then is the offset of each body's field from the plane's first vertex, in float64. It is
    empty as long as all share one field, and () in scenes where they always do.
    """

    lower: tuple[int, int, int]
    extent: tuple[int, int, int]
    stride: tuple[int, int, int]
    bodies: np.ndarray | tuple[()] = ()

    @classmethod
    def over(
        cls, lower: tuple[int, int, int], extent: tuple[int, int, int], fields: Sequence[int] = ()
    ) -> "Window":
        """Window of records, planes outermost.

        Parameters
        ----------
        lower, extent
            See `Window`.
        fields : (bodies,) int64, optional
            Number of each body's velocity field.
        """
        size = RECORD * extent[1] * extent[2]
        count = 1 + max(fields) if len(fields) else 1
        bodies = np.array(fields if count > 1 else (), np.int64) * size if len(fields) else ()
        return cls(lower, extent, (count * size, RECORD * extent[2], RECORD), bodies)
