"""Arguments of the kernels of a step: setting, field, order, forcing, report.

All are NamedTuples, which the compiler unpacks at no cost.
"""

from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pgimp.kernels.data.frame import Frame, Window
from pgimp.kernels.data.motion import VertexMotion
from pgimp.kernels.data.particles import FloatArray, IntArray, Particles


class KernelScene(NamedTuple):
    """The scene for kernels; constant during a run."""

    shape: Any  #: NamedTuple: Parameters of the shape, see `pgimp.physics.shapes`.
    frame: Frame  #: Position of the grid.
    #: tuple of D*D float: The undeformed deformation gradient; it gives the compiler the length of
    #: F.
    identity: tuple[float, ...]
    materials: tuple  #: tuple of NamedTuple: Parameters of the materials.
    material_of: IntArray  #: (bodies,) int64: Material of each body.
    tracked: bool = True  #: Whether V follows det(F) V0.
    #: Bit 2 d + s is set for an open face, of direction d at the low (s = 0) or high end (1). Bit 6
    #: + d is set where direction d is periodic.
    exits: int = 0

    def without_materials(self) -> Self:
        """For kernels without materials, to compile them once for all materials."""
        return self._replace(materials=())

    def without_shape(self) -> Self:
        """For kernels without shapes, to compile them once for all shapes."""
        return self._replace(shape=())


class Order(NamedTuple):
    """Particles in canonical order."""

    rows: NDArray[np.int32]  #: (n,) int32: Their rows.
    start: IntArray  #: (layers + 1,) int64: Beginning of each of the rank's layers in `rows`.


class FourParticles(NamedTuple):
    """Four particles of a layer, computed together."""

    rows: tuple[int, int, int, int]  #: Their rows; the last row replaces missing ones.
    size: int  #: Number of particles.
    first: int  #: Offset of the first particle in the order.
    #: layer, number: Their layer, counted from the rank's first one, and its number in the grid.
    layer: int
    number: int


class Field(NamedTuple):
    """A velocity field on a rank's planes of the grid."""

    #: The stored part of the grid; its first plane belongs to the rank's first layer.
    window: Window
    #: (planes * plane,) float64: Records of the vertices, see `pgimp.kernels.data.record`. Only
    #: those of active planes are defined.
    G: FloatArray
    #: (planes,) uint8: 1 for planes with sums of this rank's layers; zero before the first layer of
    #: a step.
    active: NDArray[np.uint8]
    #: (vertices * plane,) float64: A layer's own planes; zero between two layers.
    scratch: FloatArray
    #: float64: Sums to be added later, see `complete`. First the sums of the first `shared` layers
    #: for the planes that the lower rank shares, layer by layer, each from its own plane up. Their
    #: size is shared * (shared + 1) / 2 * plane. Then likewise the sums of the last `shared` layers
    #: for planes that the upper rank does not share. Without such a rank its part is missing.
    deferred: FloatArray
    shared_lower: int  #: Number of planes shared with the lower rank; 0 without one.
    owned: int  #: Number of planes, from the first, whose sums this rank accounts for.
    #: tuple of D pairs of float: Coordinates between which a particle is certainly in the domain
    #: and in the window.
    bounds: tuple[tuple[float, float], ...]
    #: (planes + 1, fields) int64 or (): Several velocity fields: bits of the rows along y in which
    #: each is not zero. They are cleared before its plane is active again; see
    #: `pgimp.kernels.data.velocity_fields`. The last entries are for the layer's own planes. () in
    #: scenes that always have one field.
    used: IntArray | tuple[()] = ()
    #: VertexMotion or (): Motion that the vertices keep, in scenes with bodies in the initial
    #: configuration.
    motion: VertexMotion | tuple[()] = ()


class Phase(NamedTuple):
    """What a step of another order of phases has done before the particles move.

    See `pgimp.solver.phases.orders`.
    """

    dt: float  #: Time of the strain that is left.
    particles: Particles  #: With deformation gradients so far in place of F.
    velocities: FloatArray  #: (capacity, D) float64: Velocities of the particles after the step.


class Forcing(NamedTuple):
    """Forcing of the material during one step, except the conditions of faces.

    As part of the type, each combination would need its own compilation of every kernel.
    """

    dt: float  #: Length of the step.
    gravity: tuple[float, float, float]  #: Body force per mass b, taken at the step's beginning.
    #: A vertex up to this mass gets a = 0, and keeps v = p/m. So a passing particle gets its full
    #: gradient, however small its weight.
    mass_cutoff: float
    loads: Any  #: Loads: See `pgimp.kernels.loads.loads`.
    #: tuple of Constraint or of PlacedConstraint: The constraints, see
    #: `pgimp.kernels.grid.constraints`.
    constraints: tuple
    #: (constraints, mask) or (constraints, mask, Places) or (): The constraints and their vertices,
    #: see `constrained_velocity`.
    marked: tuple
    #: (6, WALL) float64: The faces that hold particles, see `pgimp.kernels.grid.position_limits`.
    position_limits: FloatArray
    controlled: bool | float  #: Whether the next step depends on the particles' speeds.
    #: (faces, vertices) float64 or (): Clearances of bodies from unilateral walls. See
    #: `find_clearances`.
    clearances: FloatArray | tuple[()] = ()
    #: Filling or (): Filled parts of the vertices, where bodies flow. See
    #: `pgimp.kernels.flows.filling`.
    filling: Any = ()
    #: PenetrationLimits or (): Rigid bodies that hold particles out. See
    #: `pgimp.kernels.contact.hold`.
    limits: Any = ()
    phase: Phase | tuple[()] = ()  #: Phase or (): Of the step, where stress is not updated last.


class Report(NamedTuple):
    """Outcome of a step for a rank's particles."""

    #: (2, 2) int64: Grown to the first vertices (least, greatest; y, z) of particles, at least of
    #: particles beyond the field's bounds.
    vertex_bounds: IntArray
    #: (n,) int32: Filled with the offsets in the order of particles that changed their layer or
    #: left.
    changed: NDArray[np.int32]
    #: (capacity, 2) int64: Filled with row and error of particles at fault, up to its capacity.
    errors: IntArray
