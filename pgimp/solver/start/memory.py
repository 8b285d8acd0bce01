"""Memory of a run, estimated before it is used.

The terms are a rank's allocations, with the transients of the largest phase. Measured peaks are
within some ten per cent (tests/solver/test_memory.py). Further needs, when bodies spread or many
particles move to another rank at once, are not foreseen.
"""

from math import prod
from typing import NamedTuple

import numpy as np

from pgimp.decomposition.grid import LAG, MARGIN
from pgimp.kernels.data.ledger import BOOKED, TOOLED
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.rigid.bodies import RESPONSE
from pgimp.physics.fields import ALWAYS
from pgimp.scene.bodies.extent import Extent, points
from pgimp.scene.bodies.lattice_body import _SLAB
from pgimp.scene.scene import Scene
from pgimp.solver.contact.velocity_fields import assign, reach

#: Further memory of a process after its start: kernels, HDF5, buffers of MPI.
BASE = 100_000_000


class Part(NamedTuple):
    """Memory of a rank for one purpose."""

    what: str  #: Its name, for messages.
    size: float  #: Bytes.
    advice: str  #: Changes of the case that would reduce it.
    shared: bool = True  #: Whether more ranks reduce it.


class Estimate(NamedTuple):
    """Memory of a rank beyond its memory at the start."""

    particles: float  #: Of all ranks, about.
    each: int  #: Bytes for each of a rank's particles at the peak.
    parts: list[Part]  #: Memory at the peak; the largest first.
    untouched: Part  #: Further allocations, not touched without particles.

    @property
    def size(self) -> float:
        """Bytes in all."""
        return BASE + sum(part.size for part in self.parts)


def bytes_each(scene: Scene, ranks: int) -> tuple[int, int, int]:
    """Bytes of a particle: its columns, a rank's data for it, and more during output."""
    p = Particles.empty(1, scene.carried)
    columns = sum(array.nbytes for array in p)
    widest = 8 * max(array.size for array in p)
    output = scene.case.output
    fields = [*ALWAYS.values(), *(scene.fields[name] for name in output.fields)]
    field = (4 if output.precision == "float32" else 8) * max(max(1, f.columns) for f in fields)
    # Rows and their order; migrants to and from other ranks; a compressed field. It is
    # more than a checkpoint needs.
    frame = (40 if ranks == 1 else 36 + 2 * field) + field * (output.compression != "none")
    # Scratch for the widest column, order and spare order; arrivals from other ranks.
    kept = columns * (1.0 if ranks == 1 else 1.125) + widest + 8
    # Volume, row and order of particles in cells; gradients from which vertices start.
    kept += 17 * scene.by_cells
    start = 8 * scene.dimension * (scene.dimension + 3) * bool(scene.settings.lagrangian.any())
    return columns, int(kept), int(kept + max(frame, start))


def window(scene: Scene, bodies: list[Extent], ranks: int) -> list[int]:
    """Vertices along each direction around the particles at the beginning, and a margin."""
    s, per_cell = scene.settings.vertices, scene.case.method.particles_per_cell
    margin = 2 * (MARGIN + (LAG if ranks > 1 else 0))
    extent = []
    for d in range(scene.dimension):
        low = min(body.low[d] for body in bodies) // per_cell[d]
        high = -(-max(body.high[d] for body in bodies) // per_cell[d])
        extent.append(
            min(scene.domain.frame.vertices[d], high - low + s + 1 + (margin if d else 0))
        )
    return extent


def _fields(scene: Scene, bodies: list[Extent]) -> float:
    """Velocity fields at the beginning, with the sums of volumes if bodies are in contact."""
    if not scene.interaction.pairs:
        return 1
    per_cell = np.array(scene.case.method.particles_per_cell)
    ends = [np.array([getattr(body, end) for body in bodies]) / per_cell for end in ("low", "high")]
    fields = 1 + max(assign(np.stack(ends), reach(scene)))
    return fields * (2 if fields > 1 or scene.interaction.rigid_bodies else 1)


def estimate(
    scene: Scene,
    ranks: int,
    first: bool,
    bodies: list[Extent],
    count: float | None = None,
    share: float | None = None,
) -> Estimate:
    """Estimate the memory of a rank.

    Parameters
    ----------
    ranks : int
        Number of ranks.
    first : bool
        Whether it is the first rank, which gathers sums.
    bodies : list of Extent
        See `extents`.
    count : float, optional
        Particles of all ranks; by default a lower bound, unless much of the bodies is surface.
    share : float, optional
        The rank's part of the particles and layers; without it all ranks have equal parts.
    """
    case, D = scene.case, scene.dimension
    lattice, per_cell = points(case), case.method.particles_per_cell
    if count is None:
        count = sum(body.least + 0.25 * (body.most - body.least) for body in bodies)
    s = scene.settings.vertices
    layers = scene.domain.frame.vertices[0]
    if share is None:
        share = 1.0 / max(1, min(ranks, layers // (s - 1)))

    def particles(each: int) -> Part:
        return Part(
            f"{count:.3g} particles ({each} bytes each)",
            count * share * each,
            "larger cells (grid.cell) or fewer particles in them (method.particles-per-cell)",
        )

    columns, kept, most = bytes_each(scene, ranks)

    extent = window(scene, bodies, ranks)
    fields = _fields(scene, bodies)
    settings, held = scene.settings, bool(scene.interaction.loads.constraints)
    vertex = 64 * (1 + settings.by_vertex) + 32 * bool(settings.averaged.any()) + 8 * held
    plane = prod(extent[1:]) * fields * vertex
    if scene.domain.approached:
        plane += prod(extent[1:]) * fields * 8 * len(scene.domain.faces)
    occupied = min(extent[0], sum(body.boxes[0] / per_cell[0] + s for body in bodies))
    # A layer's own planes; deferred sums at both ends, and received ones.
    beside = s + (1.5 * s * (s - 1) if ranks > 1 else 0)
    vertices = " x ".join(str(n) for n in extent[1:]) or "1"
    grid = Part(
        f"the grid's window, {vertices} {'vertex' if vertices == '1' else 'vertices'} a plane",
        (occupied * share + beside) * plane,
        "larger cells (grid.cell), or bodies that lie closer together across x",
    )

    names, faces = len(scene.body_names), len(scene.domain.faces)
    line = 8 * scene.materials.sums * names
    plane_sums = (
        40
        + 32 * faces
        + 24 * len(scene.interaction.loads.booked_constraints)
        + 24 * len(scene.interaction.loads.booked_tractions)
        + line * bool(scene.settings.escapes)
    )
    plane_sums += 8 * BOOKED * len(scene.interaction.pairs.kind) if scene.interaction.pairs else 0
    plane_sums += 8 * TOOLED * len(scene.interaction.rigid_bodies)
    # For free bodies; their sums are over all planes, twice where ranks add them up.
    answers = RESPONSE.itemsize * sum(
        bool(rigid_body.free) for rigid_body in case.rigid_bodies.values()
    )
    every = answers * (share + (1 if ranks == 1 else 2))
    # The first rank gathers them all, through messages.
    gathered = (line if ranks == 1 else 2 * (line + plane_sums)) if first else 0

    def sums(each: float) -> Part:
        return Part(
            f"sums over {names} bodies by {layers:,} planes",
            layers * each,
            "a grid with fewer cells along x (grid.size, grid.cell), or fewer bodies",
            shared=False,
        )

    rows = [(prod(body.boxes[1:]), body.boxes[0]) for body in bodies]
    volumes = 24.0 * max(min(deep, _SLAB // max(row, 1) + 5) * row for row, deep in rows)
    cut = sum(
        body.surface
        for body, entry in zip(bodies, case.bodies.values(), strict=True)
        if entry.surface != "whole-particles"
    )
    measured = cut * 8 * (1 + D) * share * (1.0 if ranks == 1 else 2.0)
    counting = Part(
        f"finding the particles on a lattice of {' x '.join(f'{n:,}' for n in lattice)} boxes",
        lattice[0] * (32.0 * names + 40)
        + 32 * layers
        + 16.0 * sum(lattice)
        + 24.0 * max(lattice)
        + volumes
        + measured,
        "a grid with fewer cells (grid.size, grid.cell), or fewer bodies",
    )

    rigid = Part(
        f"the distances from {len(scene.interaction.rigid_bodies)} rigid bodies",
        40.0 * scene.interaction.rigid_bodies.points(),
        "smaller rigid bodies, without what meets nothing, or larger cells (grid.cell)",
        shared=False,
    )

    phases = [
        [counting, particles(columns)],
        [particles(most), grid, rigid, sums(share * plane_sums + every)],
        [particles(kept), grid, rigid, sums(share * (plane_sums + line) + every + gathered)],
    ]
    peak = max(phases, key=lambda parts: sum(part.size for part in parts))
    untouched = Part(
        f"addresses of the grid's {layers:,} planes",
        max(0.0, layers * share - occupied * share) * plane,
        "a domain that is shorter along x (grid.size)",
    )
    return Estimate(count, most, sorted(peak, key=lambda part: -part.size), untouched)


def size_text(n: float) -> str:
    """Format a number of bytes."""
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if n < 999.5:
            return f"{n:.3g} {unit}"
        n /= 1000
    return f"{n:.3g} PB"
