"""Slabs of a small scene, driven kernel by kernel without a case and without MPI."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from rank_threads import Comm

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.halo import Halo
from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab, slab_of
from pgimp.kernels.data.arguments import Forcing, KernelScene, Report
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import AxialFrame, Frame, identity
from pgimp.kernels.data.images import Images
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.grid.mirror import fold, reflect
from pgimp.kernels.grid.position_limits import WALL
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.loads.wall_gap import find_clearances
from pgimp.kernels.step.g2p import grid_to_particles
from pgimp.kernels.step.momentum import WHOLE, update_momentum
from pgimp.kernels.step.p2g import particles_to_grid
from pgimp.physics.materials.hooke import HookeParameters
from pgimp.physics.materials.neo_hookean import NeoHookeanParameters
from pgimp.physics.shapes import SHAPES
from pgimp.physics.shapes.gimp import GimpParameters
from pgimp.scene.faces import sides_approached, table_of, walls_approached

#: Two bodies of different models.
MATERIALS = (NeoHookeanParameters(3.0, 2.0, 1.5), HookeParameters(1.0, 4.0, 0.8))
MATERIAL_OF = np.array([0, 1], np.int64)

SEED = 20040


def materials_of(shape: Any) -> tuple:
    """Materials and the material of each body: of two models with gimp, otherwise of one.

    Particles get their stresses in the same way with each shape, and whole runs have such scenes:
    the kernels of tests with other shapes are compiled for these already.
    """
    if isinstance(shape, GimpParameters):
        return MATERIALS, MATERIAL_OF
    return MATERIALS[:1], np.zeros_like(MATERIAL_OF)


#: All shapes by their names, the fuzzy ones once more with a size that stays.
VARIANTS = (*SHAPES, "fuzzy-nearest-fixed", "fuzzy-constant-fixed")

#: One of each kind of kernel: the fuzzy shapes differ from each other in nothing but a number.
KINDS = (
    "mpm", "gimp", "finite-gimp", "cpdi-corners", "fuzzy-nearest", "fuzzy-constant-fixed",
)  # fmt: skip

IDENTITIES = tuple(tuple(np.eye(D).ravel().tolist()) for D in (1, 2, 3))


def entry(name: str, particles_per_cell: Sequence[int], **parts: Any) -> Any:
    """Entry ``method`` of a case; `name` is one of `VARIANTS`."""
    if name.endswith("-fixed"):
        name, parts = name.removesuffix("-fixed"), {"size": "fixed", **parts}
    return SHAPES[name].model_validate(
        {"shape": name, "particles-per-cell": list(particles_per_cell), **parts}
    )


def initial_half(name: str, per_cell: int) -> float:
    """Half-width of chi_p in cells, before any deformation (method.md's table)."""
    if name == "mpm":
        return 0.0
    if name.startswith("fuzzy"):
        return 1.0 if "constant" in name else 1.0 / per_cell
    if name in ("gimp", "finite-gimp"):
        return 0.5 / per_cell
    return entry(name, [per_cell]).parameters((1.0,)).half[0]


def follows(name: str) -> bool:
    """Whether the half-widths follow the deformation."""
    fuzzy = name.startswith("fuzzy") and not name.endswith("-fixed")
    return fuzzy or name in ("finite-gimp", "cpdi", "cpdi-corners")


def make_frame(shape: Any, origin: Sequence[float], cell: Sequence[float], cells: Sequence[int]):
    """Grid of `cells`, with the ghost vertices that the shape needs."""
    inverse = tuple(1.0 / float(size) for size in cell)
    return Frame(tuple(origin), tuple(cell), inverse, tuple(cells), shape.vertices - 1)


def random_particles(rng: np.random.Generator, x: np.ndarray, mean: bool = False) -> Particles:
    """Particles of two bodies at `x` (n, D), deformed, stressed, of various masses and sizes."""
    n, D = x.shape
    p = Particles.empty(n, Carried(D, mean=mean))
    p.x[:] = x
    p.v[:] = rng.normal(size=p.v.shape)
    p.F[:] += 0.2 * rng.uniform(-1.0, 1.0, p.F.shape)
    p.sigma[:] = rng.normal(size=p.sigma.shape)
    p.V0[:] = rng.uniform(0.5, 1.5, n)
    p.V[:] = p.V0 * rng.uniform(0.8, 1.2, n)
    p.m[:] = rng.uniform(0.5, 2.0, n)
    p.id[:] = rng.permutation(n)
    p.body[:] = rng.integers(0, 2, n)
    shape = p.isolation.shape
    p.isolation[:] = rng.uniform(0.0, 1.0, shape) * rng.integers(0, 2, shape)
    return p


def random_positions(rng: np.random.Generator, frame: Frame, n: int, inset: float = 0.0):
    """Positions within the domain, (n, D), at least `inset` cells from its faces."""
    xi = [rng.uniform(inset, cells - inset, n) for cells in frame.cells]
    return np.stack(xi, axis=1) * frame.cell + frame.origin


def place(particles: Particles, rows: np.ndarray, capacity: int) -> Particles:
    """The same particles in the given rows of larger arrays; NaN and nonsense in between."""
    spread = []
    for array in particles:
        larger = np.empty((capacity, *array.shape[1:]), array.dtype)
        larger.fill(np.nan if array.dtype.kind == "f" else -77)
        larger[rows] = array
        spread.append(larger)
    return Particles(*spread)


def copy_of(particles):
    return Particles(*(array.copy() for array in particles))


class Rank:
    """What one rank holds: population, grid and halo of its slab.

    Parameters
    ----------
    shape : Shape
        Entry of the case.
    slab : Slab, optional
        By default all layers of the grid.
    bounds : (2, 2) int64, optional
        First vertices that the window has to cover; by default those of the particles.

    Attributes
    ----------
    exits, capacity : int
        Faces that let particles go, and most particles at fault that are listed.
    mean : float or ()
        See `Loads`.
    """

    exits, capacity = 0, 8
    mean: Any = ()

    def __init__(
        self,
        shape: Any,
        frame: Frame,
        particles: Particles,
        slab: Slab | None = None,
        comm: Any = None,
        bounds: np.ndarray | None = None,
    ) -> None:
        self.frame, self.vertices = frame, shape.vertices
        self.shape = shape.parameters(frame.cell)
        one = identity(len(frame.cell), isinstance(frame, AxialFrame))
        self.setting = KernelScene(self.shape, frame, one, *materials_of(self.shape))
        self.slab = slab or Slab(0, frame.vertices[0], None, None)
        self.population = Population(particles, particles.capacity, self.shape, frame, self.slab)
        self.grid = Grid(frame, self.vertices, self.slab)
        self.grid.cover(self.population.vertex_bounds() if bounds is None else bounds)
        self.halo = Halo(comm, self.slab, self.vertices - 1)
        self.halo.piece = 7  # so that messages overlap with several pieces of some slabs

    def up_to_date(self) -> Particles:
        return self.population.up_to_date()

    def particles_to_grid(self, faces: tuple = ()) -> None:
        """All layers, and the exchange with the neighbours if there are any.

        Those of `faces` that want clearances will have them in the momentum update.
        """
        near: Any = [
            SimpleNamespace(
                axis=face.axis,
                side=face.side,
                condition=SimpleNamespace(approaches=hasattr(face, "approach")),
            )
            for face in faces
        ]
        self.approached = walls_approached(near)
        loads = Loads(approached=sides_approached(near, self.frame), mean=self.mean)
        grid, population = self.grid, self.population
        for array in (grid.G, grid.deferred):
            array.fill(np.nan)  # only what the kernel sets may be used
        grid.active.fill(0)
        for part in self.halo.parts(population.start):
            particles_to_grid(
                self.setting.without_materials(), grid.field, population.up_to_date(), loads,
                population.ordered, part, (),
            )  # fmt: skip
            assert not grid.scratch.any()
            self.halo.proceed(grid)
        self.halo.finish(grid)

    def update_momentum(
        self,
        dt: float,
        gravity: Sequence[float] = (),
        faces: tuple = (),
        mass_cutoff: float = 5e-13,
        mirrors: Sequence[Images] = (),
    ) -> None:
        """Momentum update; sets `impulse` (planes, faces, 3) and `work` (planes,)."""
        field = self.grid.field
        ledger = Ledger.empty(self.grid.planes, len(faces), 0)
        ledger.outside_mass[:] = np.nan
        self.impulse, self.work = ledger.impulse, ledger.work
        self.outside_mass = ledger.outside_mass
        b = (*gravity, 0.0, 0.0, 0.0)[:3]
        forcing = self.forcing(dt)._replace(gravity=b, mass_cutoff=mass_cutoff)
        near = np.empty((len(faces), len(self.grid.G) // RECORD))
        if self.approached:
            forcing = forcing._replace(clearances=near)
        for mirror in mirrors:
            if not mirror.releases:
                fold(self.frame, field, mirror, forcing, ledger)
        for wall in self.approached:
            find_clearances(self.frame, field, wall, False, near)
        for mirror in mirrors:
            if mirror.releases:
                fold(self.frame, field, mirror, forcing, ledger)
        table = table_of(faces) if faces else ()
        update_momentum(self.frame, field, table, forcing, ledger, (), WHOLE)
        for mirror in reversed(mirrors):
            reflect(self.frame, field, mirror, forcing, ledger)

    @staticmethod
    def forcing(dt: float) -> Forcing:
        """What acts in a step without loads, faces and constraints."""
        return Forcing(dt, (0.0, 0.0, 0.0), 0.0, Loads(), (), (), np.full((6, WALL), -1.0), True)

    def grid_to_particles(self, dt: float, tracked: bool = True) -> tuple:
        """First error and its row, then as the kernel from the changed layers on.

        Rows and errors of all are in `errors`, places of changed layers in ``population.changed``.
        """
        grid, population = self.grid, self.population
        self.vertex_bounds = grid.base.copy()
        errors = np.zeros((self.capacity, 2), np.int64)
        self.failed, self.outflow, *rest = grid_to_particles(
            self.setting._replace(tracked=tracked, exits=self.exits), grid.field,
            population.up_to_date(), population.ordered, np.arange(len(population.start) - 1),
            self.forcing(dt)._replace(loads=Loads(mean=self.mean)),
            Report(self.vertex_bounds, population.changed, errors),
            Ledger.empty(grid.planes, 0, 0),
        )  # fmt: skip
        self.errors = errors[: self.failed]
        row, error = self.errors[0] if self.failed else (-1, 0)
        return (int(error), int(row), *rest)

    def records(self) -> np.ndarray:
        """Records of the vertices of all of the grid, (vertices of each direction, 8); else 0."""
        grid, window = self.grid, self.grid.window
        planes = grid.G.reshape(*window.extent, 8).copy()
        planes[grid.active == 0] = 0.0
        low = window.lower
        shape = (*self.frame.vertices, 1, 1)[:3]
        full = np.zeros((max(shape[0], low[0] + window.extent[0]), *shape[1:], 8))
        where = tuple(slice(a, a + n) for a, n in zip(low, window.extent, strict=True))
        full[where] = planes
        assert not full[shape[0] :].any()  # planes beyond the grid stay empty
        return full[: shape[0]].reshape(*self.frame.vertices, 8)


def split(shape: Any, frame: Frame, particles: Particles, cuts: list[int], bounds: np.ndarray):
    """Ranks that share the particles; `cuts` as from `pgimp.decomposition.slabs.cut`."""
    whole = Rank(shape, frame, copy_of(particles))
    boxes: dict = {}
    ranks = []
    for rank in range(len(cuts) - 1):
        slab = slab_of(cuts, rank)
        layer = whole.up_to_date().layer
        mine = (layer >= slab.first) & (layer < slab.first + slab.layers)
        own = Particles(*(array[mine] for array in whole.up_to_date()))
        ranks.append(Rank(shape, frame, own, slab, Comm(rank, boxes), bounds))
    return ranks
