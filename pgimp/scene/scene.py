"""The scene: a case in the form that the solver uses, the same on every rank."""

from math import prod
from typing import Any

import numpy as np

from pgimp.case.places import located
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.data.frame import Frame, InitialFrame, MixedFrame
from pgimp.kernels.data.particles import Carried, Particles
from pgimp.kernels.grid.faces import Faces
from pgimp.kernels.grid.mirror import Mirror
from pgimp.kernels.grid.position_limits import GRAVITY
from pgimp.kernels.lagrangian.cells import MOST as MOST_OF_CELLS
from pgimp.kernels.order.order import cell_numbers
from pgimp.kernels.sums.sums import SUMS
from pgimp.mpi.communicator import Communicator
from pgimp.physics.contact.pairs import Pairs
from pgimp.physics.fields import EVERY
from pgimp.physics.materials.base import LOSSES
from pgimp.physics.materials.parameters.outside import parameters_of
from pgimp.physics.materials.parameters.states import States
from pgimp.scene.bodies.counts import count_all
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.faces import (
    AXES,
    Face,
    FaceTable,
    position_bounds,
    sides_approached,
    walls,
    walls_approached,
)
from pgimp.scene.flows import SceneFlows
from pgimp.scene.loads import SceneLoads
from pgimp.scene.rigid.rigid import SceneRigidBodies
from pgimp.scene.variations import Variations
from pgimp.schema.tables import VectorTable

#: Most cells that a particle crosses in a step whose length pgimp chooses.
MOST_CELLS = 0.5

#: Masses outside of this would leave the range of float64 in sums and products.
LEAST, MOST = 1e-200, 1e200


class Scene:
    """Everything that is constant during a stage.

    Attributes
    ----------
    dimension : int
        Directions D of the scene.
    lagrangian : (bodies,) bool
        Which bodies are in the initial configuration, where particles keep their layers and
        initial weights. `initial`: all are; `mixed`: some are.
    frame : Frame
        Position and size of the grid.
    shape : NamedTuple
        Parameters of the shape; its support has `vertices` per direction.
    materials : tuple of NamedTuple
        Parameters of the materials in use; where they vary in space (see `variations`), typical
        values. `material_of` is the material of each body.
    losses : tuple of str
        Entries of `LOSSES` that a material in use reports; `sums` is the columns of `layer_sums`.
    faces : list of Face
        Faces with a condition, x-min to z-max.
    mirrors : list of Mirror
        Faces that reflect the part of supports beyond them.
    most_mass : float
        Greatest mass that the domain can hold.
    pairs : Pairs or None
        Contact laws; None where all bodies share one velocity field.
    flows : SceneFlows or None
        The flowing bodies, if there are any.
    rigid_bodies : SceneRigidBodies
        The rigid bodies; false if there are none.
    exact : NamedTuple or ()
        Parameters of the exact solution, if the case names one; `moves` if it gives the velocities.
    setting : KernelScene
        The scene for kernels; `setting_lagrangian` is for bodies in the initial configuration
        beside others.
    placing : Frame, InitialFrame or MixedFrame
        The frame for kernels that sort particles.
    """

    def __init__(self, case: Case) -> None:
        self.case = case
        self.dimension = case.dimensions
        shape = case.method
        self.lagrangian = np.array(
            [b.configuration == "initial" for b in case.bodies.values()], bool
        )
        self.initial = bool(self.lagrangian.all())
        self.mixed = bool(self.lagrangian.any()) and not self.initial
        remote = self.initial or self.mixed  # contact at present positions, not on own grids
        parameters = shape.fixed if self.initial else shape.parameters
        self.shape = parameters(tuple(case.grid.cell))
        self.vertices: int = self.shape.vertices()
        self.tracked = shape.tracked
        self.follows = shape.follows and not self.initial
        grid = case.grid
        self.frame = Frame(
            origin=tuple(float(x) for x in grid.origin),
            cell=tuple(float(x) for x in grid.cell),
            inverse=tuple(1.0 / x for x in grid.cell),
            cells=tuple(
                round(size / cell) for size, cell in zip(grid.size, grid.cell, strict=True)
            ),
            ghost=self.vertices - 1,
        )
        if cell_numbers(self.frame.vertices) >= 2**62:
            raise CaseError("grid.cell: more cells than can be numbered; use larger ones")
        self.body_names = list(case.bodies)
        in_use = {body.material for body in case.bodies.values()}
        used = [name for name in case.materials if name in in_use]
        self.material_names = used
        self.body_material = tuple(used.index(b.material) for b in case.bodies.values())
        self.material_of = np.array(self.body_material, np.int64)
        self.materials = tuple(parameters_of(case.materials[name], self.dimension) for name in used)
        self.initial_pressures = [case.materials[name].initial_pressure for name in used]
        losses = {loss for name in used for loss in case.materials[name].LOSSES}
        self.losses = tuple(loss for loss in LOSSES if loss in losses)
        self.sums = SUMS + (len(LOSSES) if losses else 0)
        with located(case):
            self.most_mass = self._weigh(used)
        named = case.boundaries
        order = [f"{axis}-{end}" for axis in AXES for end in ("min", "max")]
        self.faces = [Face(name, named[name]) for name in order if name in named]
        #: Whether bodies in the initial configuration meet unilateral walls: at their present
        #: position, not on their own grid. These walls then come last.
        self.unilateral_walls = remote and any(face.condition.approaches for face in self.faces)
        if self.unilateral_walls:
            self.faces.sort(key=lambda face: face.condition.approaches)
        #: Faces through which particles may leave; see `grid_to_particles`.
        self.exits = sum(
            1 << order.index(face) for face, way in case.escape.items() if way == "remove"
        )
        #: Whether particles may leave, in this stage or a previous one.
        self.escapes = bool(self.exits) or case.staged.escapes
        #: Whether there may be fewer particles than at the start.
        self.loses = self.escapes or bool(case.staged.removed)
        # Unilateral walls come last: where they meet other walls, they use the sums of both.
        self.mirrors = sorted(
            (
                Mirror(face.axis, face.side, number, face.condition.releases, face.condition.sticks)
                for number, face in enumerate(self.faces)
                if shape.mirrors
                and face.condition.mirrors
                and not (remote and face.condition.approaches)
            ),
            key=lambda mirror: mirror.releases,
        )
        # Point particles give no gap: it would jump by half a cell as they move.
        near = [] if shape.chi == "point" or remote else self.faces
        self.approached = walls_approached(near)
        entries = [case.materials[name] for name in used]
        self.exact: Any = case.exact.parameters(case) if case.exact else ()
        self.moves = bool(case.exact) and case.exact.moves
        force = self.exact if case.exact and case.exact.forced else ()
        if case.body_force:
            force = case.body_force.parameters()
        self.loads = SceneLoads(
            case, used, force, sides_approached(near, self.frame), shape.follows & ~self.lagrangian
        )
        self.rigid_bodies = SceneRigidBodies(case, self.frame)
        self.pairs: Pairs | None = None
        if case.contact or self.rigid_bodies or self.mixed:
            self.pairs = Pairs.of(case.contact, [*self.body_names, *self.rigid_bodies.names])
        of_bodies = self.material_of, ~self.lagrangian
        flows = SceneFlows(case, entries, *of_bodies, self.faces, self.pairs)
        self.flows = flows if flows.rates.any() else None
        self.states = States(used, self.materials, self.dimension)
        self.variations = Variations(case, used, self.materials, self.states.width)
        #: Greatest initial density of a particle, set where materials vary once computed.
        self.densest: float | None = None
        self.fields = EVERY | self.states.fields | self.variations.fields
        self.carried = Carried(
            self.dimension,
            self.origins,
            **self.loads.carried,
            state=self.states.width,
            surfaces=self.pairs is not None or self.unilateral_walls,
            own=self.variations.width, liquid=bool(self.flows and self.flows.relaxes),
        )  # fmt: skip
        #: Columns of the particles at the start, whose velocity gradients vertices may need.
        self.created = self.carried._replace(
            affine=self.carried.affine or bool(self.lagrangian.any())
        )
        loads = self.loads.at(0.0)
        self._by_cells = (
            self.initial
            and self.dimension > 1
            and shape.in_cell
            and max(shape.particles_per_cell) <= MOST_OF_CELLS
            and all(hasattr(type(each), "piola") for each in self.materials)
            and not (self.variations or loads.tractions or case.staged.rebonds)
            and loads.viscosity == loads.force == loads.mean_lagrangian == ()
        )
        # Faces that bodies approach vary by the length of the step alone.
        moves = any(each.condition.varies and not each.condition.approaches for each in self.faces)
        self._face_table = FaceTable(
            [
                face
                for face in self.faces
                if not (self.unilateral_walls and face.condition.approaches)
            ]
        )
        self._gravity = self._gravity_at(0.0)
        self._walls = None if moves else walls(self.faces, self.frame, 0.0)
        if self._walls is not None:
            self._walls[:, GRAVITY] = np.repeat(self._gravity, 2)
        #: Coordinate limits of particles that the grid does not limit.
        self.bounds = position_bounds(self.faces, self.frame) if remote else None
        D = self.dimension
        self.identity = tuple(float(i == j) for i in range(D) for j in range(D))
        start = InitialFrame(*self.frame)
        frame = start if self.initial else self.frame
        self.setting = KernelScene(
            self.shape, frame, self.identity, self.variations.materials, self.material_of,
            self.tracked, self.exits,
        )  # fmt: skip
        self.setting_lagrangian = self.setting._replace(
            shape=shape.fixed(self.frame.cell), frame=start
        )
        self.placing: Any = MixedFrame(*self.frame, self.lagrangian) if self.mixed else frame

    def _weigh(self, materials: list[str]) -> float:
        """Mass of a domain full of the densest material; refuse masses that no float64 can sum."""
        grid, each = self.case.grid, prod(self.case.method.particles_per_cell)
        most = 0.0
        for name in materials:
            density = self.case.materials[name].density
            particle = density * prod(grid.cell) / each
            domain = density * prod(grid.size)
            if not (particle > LEAST and domain < MOST):
                raise CaseError(
                    f"materials.{name}.density: a particle would have the mass {particle:.3g}, a "
                    f"full domain {domain:.3g}; with numbers below {LEAST:g} or above {MOST:g} "
                    "nothing can be computed: choose other units"
                )
            most = max(most, domain)
        return most

    @property
    def ends(self) -> int:
        """Least number of layers of the first rank and of the last rank."""
        # A vertex beyond a face and its mirror image are on the same rank.
        if self.mirrors or self.flows:
            return 2 * self.vertices
        # A vertex beyond a unilateral wall uses the clearance of the vertex on the wall.
        return self.vertices if self.approached else 0

    @property
    def by_cells(self) -> bool:
        """Whether lattice particles are summed by `pgimp.kernels.lagrangian.cells`."""
        return self._by_cells

    @property
    def lagrangian_bodies(self) -> np.ndarray | None:
        """Mask of the bodies whose vertices keep their motion; None without any."""
        return self.lagrangian if self.lagrangian.any() else None

    @property
    def origins(self) -> bool:
        """Whether particles store their initial position."""
        lagrangian = self.initial or self.mixed
        return lagrangian or bool(self.exact) or "displacement" in self.case.output.fields

    @property
    def controlled(self) -> bool | float:
        """How steps follow the fastest wave, if at all; see `pgimp.kernels.update.pace`."""
        courant = self.case.courant
        if courant is None or not self.case.watched:
            return courant is not None
        return courant / MOST_CELLS

    def gravity(self, t: float) -> tuple[float, float, float]:
        """Gravity at a time, force per mass; zero in directions that the scene does not have."""
        return self._gravity_at(t) if isinstance(self.case.gravity, VectorTable) else self._gravity

    def _gravity_at(self, t: float) -> tuple[float, float, float]:
        b = self.case.gravity
        if b is None:
            return (0.0, 0.0, 0.0)
        value = b.value(t) if isinstance(b, VectorTable) else b
        x, y, z = (*(float(c) for c in value), 0.0, 0.0)[:3]
        return (x, y, z)

    def face_parameters(self, start: float, end: float) -> Faces | tuple[()]:
        """Conditions of the faces in a step, `Faces` or (); valid until the next call."""
        return self._face_table.at(start, end)

    def standing_faces(self) -> Faces | tuple[()]:
        """All faces with a condition, for kernels that only need their positions."""
        return FaceTable(self.faces).at(0.0, 1.0)

    def walls(self, start: float, end: float) -> np.ndarray:
        """Faces that hold particles in during a step; valid until the next call.

        See `pgimp.kernels.grid.position_limits`.
        """
        found = self._walls
        if found is None:
            found = walls(self.faces, self.frame, end)
        elif not isinstance(self.case.gravity, VectorTable):
            return found
        found[:, GRAVITY] = np.repeat(self.gravity(start), 2)
        return found

    def weighed(self, particles: Particles, rows: np.ndarray) -> np.ndarray:
        """Positions that the weights of particles refer to, (n, D): present or initial."""
        if self.initial:
            return particles.origin[rows]
        if self.mixed:
            lagrangian = self.lagrangian[particles.body[rows]]
            return np.where(lagrangian[:, None], particles.origin[rows], particles.x[rows])
        return particles.x[rows]

    def varies(self, body: int) -> bool:
        """Whether the material of a body varies in space."""
        return self.variations.layouts[self.body_material[body]] is not None

    def weigh(self, densest: float) -> None:
        """Set the greatest density of particles whose materials vary."""
        self.densest = densest
        self.most_mass = densest * prod(self.case.grid.size)


def count_particles(scene: Scene, comm: Communicator) -> tuple[Lattice, np.ndarray, list[str]]:
    """Count the particles: lattice, counts by body and plane, and notes; collective.

    Raises
    ------
    CaseError
        See `pgimp.scene.bodies.counts.count_all`.
    """
    lattice = Lattice(scene.case)
    with located(scene.case):
        taken = count_all(lattice, comm)
        if int(taken.counts.sum()) >= 2**53:
            raise CaseError("grid.cell: more particles than can be numbered; use larger cells")
    return lattice, taken.counts, taken.notes
