"""The scene: a case in the form that the solver uses, the same on every rank."""

from typing import Any

import numpy as np

from pgimp.case.schema import Case
from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import FRAMES, mixed_frame
from pgimp.kernels.data.particles import Particles, needed_by
from pgimp.kernels.lagrangian.cell_derivatives import MAX_PER_CELL
from pgimp.kernels.loads.loads import Loads
from pgimp.physics.fields import EVERY
from pgimp.physics.shapes.parts import PartParameters
from pgimp.scene.domain import Domain
from pgimp.scene.interaction import Interaction
from pgimp.scene.mass_scaling import scaled
from pgimp.scene.materials import MaterialTable
from pgimp.scene.settings import Settings


class Scene:
    """Everything that is constant during a stage.

    Attributes
    ----------
    case
        The stage's, with the inertia of mass scaling.
    dimension : int
        Directions D of the scene.
    settings : Settings
        Configurations, shape, exact solution.
    domain : Domain
        Grid, faces, gravity.
    materials : MaterialTable
        Materials in use.
    interaction : Interaction
        Loads, rigid bodies, contact pairs, flowing bodies.
    fields : dict
        Output fields of the particles by name.
    carried : Carried
        Columns of the particles; `created` is the columns at the start, whose velocity gradients
        vertices may need.
    setting : KernelScene
        The scene for kernels; `setting_lagrangian` is for bodies in the initial configuration
        beside others.
    order_frame : Frame, InitialFrame, MixedFrame or MixedExactFrame
        The frame for kernels that sort particles.
    by_cells : bool
        Whether lattice particles are summed by `pgimp.kernels.lagrangian.cells`.
    cell_loads : Loads or ()
        The loads on them; () if they are elastic, so that their columns are only for output.
    stateless : bool
        Whether particles in cells have no state of their own: all follows from the vertices.
    ends : int
        Least number of layers of the first rank and of the last rank.
    """

    def __init__(self, case: Case) -> None:
        self.case = case = scaled(case)
        self.dimension = D = case.dimensions
        self.body_names = list(case.bodies)
        self.settings = settings = Settings(case)
        self.domain = domain = Domain(case, settings)
        self.materials = materials = MaterialTable(case)
        self.interaction = Interaction(case, settings, domain, materials)
        pairs, loads = self.interaction.pairs, self.interaction.loads
        self.fields = EVERY | materials.states.fields | materials.variations.fields
        self.carried = Carried(
            D,
            settings.origins,
            **loads.carried,
            state=materials.states.width,
            surfaces=pairs is not None or domain.unilateral_walls,
            own=materials.variations.width,
            liquid=bool(self.interaction.flows and self.interaction.flows.relaxes),
            axial=case.axisymmetric,
            plate=case.geometry == "plane-stress",
            needed=needed_by(case),
            products=PartParameters.products(D, case.axisymmetric)
            if settings.exact_surfaces.any()
            else 0,
        )
        self.created = self.carried._replace(affine=self.carried.affine or settings.by_vertex)
        start, shape = FRAMES[case.geometry][1](*domain.frame), case.method
        frame = start if settings.initial else domain.frame
        of_body = np.array(materials.body_material, np.int64)
        self.setting = KernelScene(
            settings.shape,
            frame,
            self.carried.undeformed,
            materials.variations.materials,
            of_body,
            shape.tracked,
            domain.exits,
        )
        self.setting_lagrangian = self.setting._replace(shape=settings.initial_shape, frame=start)
        self.order_frame: Any = frame
        if settings.mixed:
            exact = bool(settings.exact_surfaces.any())
            self.order_frame = mixed_frame(domain.frame, settings.lagrangian, exact)
        self.by_cells = self._by_cells()
        self.cell_loads = self._cell_loads()
        self.stateless = self.by_cells and not self.cell_loads
        self.ends = self._ends()

    def _by_cells(self) -> bool:
        method, loads = self.case.method, self.interaction.loads.at(0.0)
        return (
            self.settings.initial
            and self.dimension > 1
            and self.case.geometry == "plane-strain"
            and method.in_cell
            and max(method.particles_per_cell) <= MAX_PER_CELL
            and not (loads.force or self.case.staged.rebonds)
        )

    def _cell_loads(self) -> Loads | tuple[()]:
        materials, loads = self.materials, self.interaction.loads.at(0.0)
        elastic = (
            all(hasattr(type(each), "piola") for each in materials.parameters)
            and not materials.variations
            and not loads.viscosity
            and isinstance(loads.mean_lagrangian, tuple)
        )
        return () if elastic else Loads(loads.viscosity, mean_lagrangian=loads.mean_lagrangian)

    def _ends(self) -> int:
        # A vertex beyond a face and its mirror image are on the same rank.
        if self.domain.mirrors or self.domain.absorbing_mirrors or self.interaction.flows:
            return 2 * self.settings.vertices
        # A vertex beyond a unilateral wall uses the clearance of the vertex on the wall.
        return self.settings.vertices if self.domain.approached else 0

    def weighed(self, particles: Particles, rows: np.ndarray) -> np.ndarray:
        """Positions that the weights of particles refer to, (n, D): present or initial."""
        if self.settings.initial:
            return particles.origin[rows]
        if self.settings.mixed:
            lagrangian = self.settings.lagrangian[particles.body[rows]]
            return np.where(lagrangian[:, None], particles.origin[rows], particles.x[rows])
        return particles.x[rows]
