"""Arguments of the kernels of a step: setting, field, order, forcing, report.

All are NamedTuples, which the compiler unpacks at no cost.
"""

from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pgimp.kernels.data.frame import Frame, Window
from pgimp.kernels.data.motion import VertexMotion
from pgimp.kernels.data.particles import FloatArray, IntArray


class KernelScene(NamedTuple):
    """The scene for kernels; constant during a run.

    Attributes
    ----------
    shape : NamedTuple
        Parameters of the shape, see `pgimp.physics.shapes`.
    frame : Frame
        Position of the grid.
    identity : tuple of D*D float
        The undeformed deformation gradient; it gives the compiler the length of F.
    materials : tuple of NamedTuple
        Parameters of the materials.
    material_of : (bodies,) int64
        Material of each body.
    tracked : bool
        Whether V follows det(F) V0.
    exits : int
        Bit 2 d + s is set for an open face, of direction d at the low (s = 0) or high end (1).
        Bit 6 + d is set where direction d is periodic.
    """

    shape: Any
    frame: Frame
    identity: tuple[float, ...]
    materials: tuple
    material_of: IntArray
    tracked: bool = True
    exits: int = 0

    def without_materials(self) -> Self:
        """For kernels without materials, to compile them once for all materials."""
        return self._replace(materials=())

    def without_shape(self) -> Self:
        """For kernels without shapes, to compile them once for all shapes."""
        return self._replace(shape=())


class Order(NamedTuple):
    """Particles in canonical order.

    Attributes
    ----------
    rows : (n,) int32
        Their rows.
    start : (layers + 1,) int64
        Beginning of each of the rank's layers in `rows`.
    """

    rows: NDArray[np.int32]
    start: IntArray


class FourParticles(NamedTuple):
    """Four particles of a layer, computed together.

    Attributes
    ----------
    rows : tuple of 4 int
        Their rows; the last row replaces missing ones.
    size : int
        Number of particles.
    first : int
        Offset of the first particle in the order.
    layer, number : int
        Their layer, counted from the rank's first one, and its number in the grid.
    """

    rows: tuple[int, int, int, int]
    size: int
    first: int
    layer: int
    number: int


class Field(NamedTuple):
    """A velocity field on a rank's planes of the grid.

    Attributes
    ----------
    window : Window
        The stored part of the grid; its first plane belongs to the rank's first layer.
    G : (planes * plane,) float64
        Records of the vertices, see `pgimp.kernels.data.record`. Only those of active planes are
        defined.
    active : (planes,) uint8
        1 for planes with sums of this rank's layers; zero before the first layer of a step.
    scratch : (vertices * plane,) float64
        A layer's own planes; zero between two layers.
    deferred : float64
        Sums to be added later, see `complete`. First the sums of the first `shared` layers for the
        planes that the lower rank shares, layer by layer, each from its own plane up. Their size is
        shared * (shared + 1) / 2 * plane. Then likewise the sums of the last `shared` layers for
        planes that the upper rank does not share. Without such a rank its part is missing.
    shared_lower : int
        Number of planes shared with the lower rank; 0 without one.
    owned : int
        Number of planes, from the first, whose sums this rank accounts for.
    bounds : tuple of D pairs of float
        Coordinates between which a particle is certainly in the domain and in the window.
    used : (planes + 1, fields) int64 or ()
        Several velocity fields: bits of the rows along y in which each is not zero. They are
        cleared before its plane is active again; see `pgimp.kernels.data.velocity_fields`. The last
        entries are for the layer's own planes. () in scenes that always have one field.
    motion : VertexMotion or ()
        Motion that the vertices keep, in scenes with bodies in the initial configuration.
    """

    window: Window
    G: FloatArray
    active: NDArray[np.uint8]
    scratch: FloatArray
    deferred: FloatArray
    shared_lower: int
    owned: int
    bounds: tuple[tuple[float, float], ...]
    used: IntArray | tuple[()] = ()
    motion: VertexMotion | tuple[()] = ()


class Forcing(NamedTuple):
    """Forcing of the material during one step, except the conditions of faces.

    As part of the type, each combination would need its own compilation of every kernel.

    Attributes
    ----------
    dt : float
        Length of the step.
    gravity : tuple of 3 float
        Body force per mass b, taken at the step's beginning.
    mass_cutoff : float
        A vertex up to this mass gets a = 0, and keeps v = p/m. So a passing particle gets its full
        gradient, however small its weight.
    loads : Loads
        See `pgimp.kernels.loads.loads`.
    constraints : tuple of Constraint or of PlacedConstraint
        The constraints, see `pgimp.kernels.grid.constraints`.
    marked : (constraints, mask) or (constraints, mask, Places) or ()
        The constraints and their vertices, see `constrained_velocity`.
    position_limits : (6, WALL) float64
        The faces that hold particles, see `pgimp.kernels.grid.position_limits`.
    controlled : bool or float
        Whether the next step depends on the particles' speeds.
    clearances : (faces, vertices) float64 or ()
        Clearances of bodies from unilateral walls. See `find_clearances`.
    filling : Filling or ()
        Filled parts of the vertices, where bodies flow. See `pgimp.kernels.flows.filling`.
    limits : PenetrationLimits or ()
        Rigid bodies that hold particles out. See `pgimp.kernels.contact.hold`.
    """

    dt: float
    gravity: tuple[float, float, float]
    mass_cutoff: float
    loads: Any
    constraints: tuple
    marked: tuple
    position_limits: FloatArray
    controlled: bool | float
    clearances: FloatArray | tuple[()] = ()
    filling: Any = ()
    limits: Any = ()


class Report(NamedTuple):
    """Outcome of a step for a rank's particles.

    Attributes
    ----------
    vertex_bounds : (2, 2) int64
        Grown to the first vertices (least, greatest; y, z) of particles, at least of particles
        beyond the field's bounds.
    changed : (n,) int32
        Filled with the offsets in the order of particles that changed their layer or left.
    errors : (capacity, 2) int64
        Filled with row and error of particles at fault, up to its capacity.
    """

    vertex_bounds: IntArray
    changed: NDArray[np.int32]
    errors: IntArray
