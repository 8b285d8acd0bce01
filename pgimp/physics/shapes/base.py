"""Base of the entries of shapes, and the kernels' view of a shape."""

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from pgimp.jit.kernel import class_of, exact, inlined, of_types
from pgimp.physics.shapes.courant import LIMITS
from pgimp.physics.shapes.phases import STABLE_AVERAGE, STRESS, StressOrder
from pgimp.schema.base import Count, Model, NonNegative, chosen, or_auto
from pgimp.schema.dispatch import Either


class Shape(Model):
    """Base of the entries ``method``."""

    particles_per_cell: tuple[Count, ...] = Field(
        default=(),
        alias="particles-per-cell",
        description="particles per cell along each direction",
        json_schema_extra=chosen,
    )

    relaxation: Annotated[
        float | Literal["auto"],
        Either("a rate from 0 on or auto", {float: NonNegative, str: Literal["auto"]}),
    ] = Field(
        default="auto",
        alias="pic-damping",
        description="rate at which particles' velocities relax to the grid's (PIC): damps noise "
        "that the grid cannot resolve, and slightly also motion that it can; 0: none; auto: of "
        "loose soil and grains, in the current configuration, 0.002 c/h to the body's own motion, "
        "with the speed of waves c and the least side h of a cell; where all bodies are liquids, "
        "0.01 nu/h^2 with the least kinematic viscosity nu, none below 1e-5 c/h [1/time]",
    )

    affine: bool = Field(
        default=False,
        description="whether particles give the grid the gradient of their velocity too, "
        "v + L (x_v - x_p), so that velocities linear in space arrive exactly up to free surfaces: "
        "spin lasts, waves and slow vibrations lose less; recommended for bodies that move. "
        "Particles that reach a vertex held by a face or a constraint go without the gradient of "
        "the components held there, which would create energy",
        json_schema_extra=or_auto,
    )

    volumetric: Literal["pointwise", "b-bar"] = Field(
        default="pointwise",
        description="rate of volume change that particles see: pointwise, the divergence of the "
        "grid's velocity at their place; b-bar, that of the cells in which their boxes lie, each "
        "cell having one, the mean: nearly incompressible and plastic materials then do not lock. "
        "For boxes (gimp, finite-gimp, cpdi), in either configuration; in 1D it makes no "
        "difference",
        json_schema_extra=or_auto,
    )

    stress: StressOrder = STRESS

    mass: Literal["lumped", "averaged"] = Field(
        default="lumped",
        description="mass of the vertices of bodies in the initial configuration: lumped, each its "
        "own part, with which short waves are slow; averaged, some way from there to the "
        "consistent mass, so that the leading error of waves cancels: a wave of ten cells is four "
        "times as accurate, in steps 0.85 times as long. Settling keeps the lumped mass",
        json_schema_extra=or_auto,
    )

    #: Vertices per direction in a support.
    vertices: ClassVar[int]

    #: Whether lattice particles, undeformed, reach the corners of their cell only, linearly: points
    #: and boxes.
    in_cell: ClassVar[bool] = False

    #: Whether it has weights of rings, for axisymmetry; see `moments`.
    rings: ClassVar[bool] = False

    #: Whether supports reach two cells and more to each side, for any number of particles a cell.
    wide: ClassVar[bool] = False

    #: Whether nearly incompressible solids lock with pointwise volumes.
    locks: ClassVar[bool] = True

    #: Largest stable Courant numbers by dimensions and particles a cell along each direction: with
    #: the key "" of the shape, "affine" of it with that transfer, "vertices" of bodies in the
    #: initial configuration. What is not here is looked up in `LIMITS` and `VERTEX_LIMITS`.
    limits: ClassVar[dict[str, dict[int, dict[int, float]]]] = {}

    #: Courant number up to which free surfaces stay stable at any position in their cells. With
    #: pointwise volumes and up to four particles a cell and direction (``scripts/hard courant``).
    stable_pointwise: ClassVar[float] = 0.45

    @property
    def name(self) -> str:
        """Its name in a case, the field `shape` of each shape."""
        return getattr(self, "shape", "")

    @property
    def stable(self) -> float:
        """Courant number up to which free surfaces stay stable; above, there is a warning.

        Mean dilatation needs shorter steps. There the outermost vertices get more force from cells
        than from particles, the more so the smaller the particles.
        """
        if self.volumetric == "pointwise" or len(self.particles_per_cell) == 1:
            symmetric = self.stress == "average" and not self.affine
            return STABLE_AVERAGE if symmetric else self.stable_pointwise
        most, of_one = (0.45, 0.75) if len(self.particles_per_cell) == 2 else (0.35, 0.52)
        return min(most, of_one / max(self.particles_per_cell))

    def largest_courant(self, dimensions: int) -> float:
        """Largest Courant number measured as stable with these particles and transfer.

        See `LIMITS`. It is `stable` where nothing was measured (``scripts/hard courant``), and
        with mean dilatation, which the table does not cover.
        """
        how = "affine" if self.affine else ""
        known = self.limits.get(how) or LIMITS.get(f"{self.name}{how and ', affine'}", {})
        found = known.get(dimensions) or known.get(dimensions - 1)  # nearly the same in 2D and 3D
        averages = self.volumetric == "b-bar" and dimensions > 1
        if found is None or averages or (self.stress == "average" and not self.affine):
            return self.stable
        most = max(self.particles_per_cell)
        for per_cell, limit in found.items():
            if most <= per_cell:
                return limit
        return limit * per_cell / most

    @property
    def tracked(self) -> bool:
        """Whether the volume in the internal force (16) follows det(F)."""
        return True

    #: Kind of the characteristic function chi_p.
    chi: ClassVar[Literal["point", "box", "tent"]] = "box"

    #: Whether weights are means of the tent over the ends of a box, not over all of it.
    ends: ClassVar[bool] = False

    @property
    def follows(self) -> bool:
        """Whether the particles' size follows the deformation."""
        return False

    @property
    def is_point(self) -> bool:
        """Whether a particle is a point."""
        return self.chi == "point"

    @property
    def keeps_size(self) -> bool:
        """Whether particles are boxes whose size stays."""
        return self.chi == "box" and not self.follows

    @property
    def separable(self) -> bool:
        """Whether weights are products over the grid's directions."""
        return True

    @abstractmethod
    def parameters(self, cell: tuple[float, ...]) -> Any:
        """Parameters of the kernels, in units of the sides of a cell."""

    def fixed(self, cell: tuple[float, ...]) -> Any:
        """Parameters of the kernels for constant initial weights.

        If the size follows the deformation, they belong to a shape of constant size with the
        weights of undeformed particles.
        """
        return self.parameters(cell)


def beyond_walls(default: str) -> Any:
    """Field ``wall`` of the shapes whose particles have a size, with this default."""
    return Field(
        default=default,
        description="what happens to the part of a particle beyond a face with a condition: "
        "mirror reflects it, but at faces that move or have friction; ghost gives it to vertices "
        "beyond the face, where it is lost; auto: mirror where all bodies "
        "are liquids or gases, else ghost",
    )


class WideShape(Shape):
    """Base of the shapes whose particles have a size, and so reach past walls."""

    wall: Literal["ghost", "mirror", "auto"] = beyond_walls("auto")


class PointShape(Shape):
    """Base of the shapes whose size never changes, where the volume is a choice."""

    volume: Literal["tracked", "initial"] = Field(
        default="tracked",
        description="volume from which internal forces are computed: tracked, the current one, "
        "det(F) times the initial one; initial, as in the MPM and GIMP runs of Bardenhagen and "
        "Kober (2004)",
    )

    @property
    def tracked(self) -> bool:
        """See `Shape.tracked`."""
        return self.volume == "tracked"


@exact  # all kernels must find the same layer, in any code
def size(shape, cell, F):
    """Half-widths of chi_p by direction, in cells, and the largest before clamping."""
    return class_of(shape).size(shape, cell, F)


@inlined
def weights(shape, half, f):
    """Weights and cell-scaled gradients of the support's vertices, two tuples."""
    return class_of(shape).weights(shape, half, f)


@inlined
def moments(shape, half, f, g):
    """First moments and end values of the tents over a particle's extent, for axisymmetry.

    With the distance u from the particle, in cells, these are the means of N u over it; and the
    means of N at its two ends less the mean over it. Two tuples, as of `weights`, whose gradients
    are `g`.
    """
    return class_of(shape).moments(shape, half, f, g)


@exact
def edges(shape, F):
    """Half edges of a particle's parallelogram: D tuples of D components, in cells."""
    return class_of(shape).edges(shape, F)


@of_types
def by_corners(shape):
    """Whether a shape, given by its Numba type, has corners (`edges`) in place of `weights`."""
    return hasattr(shape.instance_class, "edges")


@of_types
def by_parts(shape):
    """Whether a shape, given by its Numba type, is of parts of cells, with `products`."""
    return hasattr(shape.instance_class, "products")
