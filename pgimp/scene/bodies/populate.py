"""Initial particles of a scene: positions, velocities, and all other columns."""

from collections.abc import Callable
from itertools import chain

import numpy as np

from pgimp.case.locations import located
from pgimp.errors import CaseError
from pgimp.geometry.points.block import Block
from pgimp.geometry.regions import Points
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.sums.errors import initial_velocities
from pgimp.physics.loads.own_velocity import OwnVelocity
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.materials.base import has
from pgimp.scene.bodies.clouds.cloud_gradients import with_gradients
from pgimp.scene.bodies.clouds.point_cloud import Cloud
from pgimp.scene.bodies.elements import Elements
from pgimp.scene.bodies.lattice import Lattice, ParticleBlock
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.saved_state import restore_state
from pgimp.scene.bodies.surface_elements import find_elements
from pgimp.scene.bodies.surfaces.boxes import Closed
from pgimp.scene.bodies.surfaces.parts import AWAY, parts_of
from pgimp.scene.bodies.surfaces.whole import face_elements
from pgimp.scene.scene import Scene


def populate(
    scene: Scene,
    lattice: Lattice,
    counts: np.ndarray,
    planes: tuple[int, int],
    own: Callable[[int, Block], np.ndarray] | None = None,
) -> Particles:
    """Create the particles of a range of lattice planes, ordered by body and position.

    Parameters
    ----------
    counts : (bodies, planes) int64
        Particles of each body in each plane of the lattice.
    planes : (int, int)
        First plane and end.
    own : callable, optional
        See `Lattice.make`; its selection may differ from the counts of the planes.
    """
    # Files must be read before their number of particles is known.
    files: list[list[ParticleBlock] | None] = []
    for body, found in enumerate(lattice.bodies):
        blocks = None
        if isinstance(found, Cloud) and counts[body].any():
            blocks = list(lattice.make(planes, counts, body, own))
            if scene.created.affine:
                blocks = with_gradients(found, lattice.box, blocks)
        files.append(blocks)
    n = sum(
        int(counts[body, planes[0] : planes[1]].sum())
        if blocks is None
        else sum(len(block.ids) for block in blocks)
        for body, blocks in enumerate(files)
    )
    p = Particles.empty(max(n, 1), scene.created)
    row, saved = 0, list[tuple[slice, ParticleBlock]]()
    every = (
        lattice.make(planes, counts, body) if blocks is None else blocks
        for body, blocks in enumerate(files)
    )
    for block in chain.from_iterable(every):
        rows = slice(row, row + len(block.ids))
        p.x[rows] = block.places(np.array(lattice.box))
        if block.products is not None:
            p.products[rows] = block.products
        # A field linear in space has its mean over a part (5) at the part's centroid. An exact
        # solution refers to the particle's position.
        points = block.positions if scene.settings.moves else block.centroids
        if block.velocities is None:
            p.v[rows] = velocities(scene, block.body, points)
        else:
            p.v[rows] = block.velocities
        material = scene.materials.body_material[block.body]
        if p.L.shape[1]:
            p.L[rows, : scene.dimension**2] = (  # at the start the hoop has no rate
                _velocity_gradients(scene, block.body, points)
                if block.gradients is None
                else block.gradients
            )
        p.id[rows] = block.ids
        p.body[rows] = block.body
        p.V0[rows] = p.V[rows] = lattice.volume * block.fractions  # (3)
        if scene.case.axisymmetric and block.rows is None:  # files have the volumes of rings
            p.V0[rows] = p.V[rows] = p.V[rows] * scene.domain.circumference(block.centroids)
        if scene.carried.surfaces:
            p.offset[rows] = block.centroids - p.x[rows]
            p.excess[rows, 0] = lattice.excess(block)
        p.m[rows] = p.V0[rows] * scene.materials.parameters[material].density  # (4)
        if block.saved:
            saved.append((rows, block))
        else:
            set_stress(scene, p, rows, block)
        row += len(block.ids)
    p.initialise(list(scene.case.bodies.values()))
    scene.interaction.loads.initialise(p, row)
    for rows, block in saved:
        restore_state(scene, p, rows, block)
    _set_surfaces(scene, lattice, p, row, planes)
    return p


def _set_surfaces(
    scene: Scene, lattice: Lattice, p: Particles, n: int, planes: tuple[int, int]
) -> None:
    """Set the parts of loaded surfaces that the first `n` particles carry."""
    loads = scene.interaction.loads.surfaces
    width = loads.width
    for k, entry in enumerate(loads.entries.values()):
        number = scene.body_names.index(entry.body)
        body, mine = lattice.bodies[number], np.flatnonzero(p.body[:n] == number)
        if isinstance(body, LatticeBody):
            ring = scene.case.axisymmetric
            found = _elements(entry, body, (planes[0] - AWAY, planes[1] + AWAY), loads.closed)
            parts, bearing = parts_of(body, found, p.x[mine], ring)
            p.surface[mine, k * width : (k + 1) * width] = parts
            if more := scene.carried.bearing:
                p.bearing[mine, k * more : (k + 1) * more] = bearing


def _elements(
    entry: TractionEntry, body: LatticeBody, planes: tuple[int, int], closed: Closed
) -> Elements:
    """Elements of the surface that a load is on, in a range of lattice planes."""
    if entry.region is None:
        return face_elements(body, entry.axis, entry.side, planes)
    found = find_elements(body, entry.region, planes, closed)
    return found.chosen(entry.normal.includes(found.area)) if entry.normal else found


def set_stress(scene: Scene, p: Particles, rows: slice, block: ParticleBlock) -> None:
    """Set stress, state, varying parameters and mass of a block's particles."""
    material = scene.materials.body_material[block.body]
    if block.stresses is not None:
        p.sigma[rows] = block.stresses[:, : p.sigma.shape[1]]
    elif pressure := scene.materials.initial_pressures[material]:
        p.sigma[rows, :3] = -pressure
    p.state[rows] = scene.materials.states.initial[material]
    _vary(scene, p, rows, block)
    for name, values in block.states.items():
        first = scene.materials.states.first(name, material)
        if first >= 0:  # else a varying parameter
            p.state[rows, first : first + values.shape[1]] = values


def prestressed(scene: Scene) -> list[int]:
    """Bodies whose particles store the stress of their start in other states."""
    given = scene.case.start.stress, scene.case.staged.stress
    return [
        number
        for number, (name, body) in enumerate(scene.case.bodies.items())
        if (
            any(each is not None and each.begins(name) for each in given)
            or (
                isinstance(body.region, Points)
                and body.region.summary.stress
                and not body.region.summary.saved
            )
        )
        and scene.case.materials[body.material].states
        and has(
            type(scene.materials.parameters[scene.materials.body_material[number]]), "initial_state"
        )
    ]


def velocities(scene: Scene, body: int, positions: np.ndarray) -> np.ndarray:
    """Initial velocity of a body's particles, (n, D): exact, or v0 + omega x (x - about)."""
    if scene.settings.moves:
        v = np.zeros_like(positions)
        initial_velocities(scene.settings.exact, scene.domain.frame, positions, v)
        return v
    motion = scene.case.bodies[scene.case.body_names[body]].velocity
    D = scene.dimension
    if isinstance(motion, OwnVelocity):
        return own_velocities(scene, body, motion, positions)
    if isinstance(motion, tuple):
        return np.tile(np.array(motion, float), (len(positions), 1))
    v = np.zeros_like(positions)
    if motion.translation is not None:
        v += motion.translation
    arm = np.zeros((len(positions), 3))
    arm[:, :D] = positions - np.array(motion.rotation.about)
    rate = motion.rotation.rate
    omega = (0.0, 0.0, rate) if isinstance(rate, float | int) else rate
    turn = np.stack(
        [
            omega[1] * arm[:, 2] - omega[2] * arm[:, 1],
            omega[2] * arm[:, 0] - omega[0] * arm[:, 2],
            omega[0] * arm[:, 1] - omega[1] * arm[:, 0],
        ],
        axis=1,
    )
    return v + turn[:, :D]


def own_velocities(
    scene: Scene, body: int, motion: OwnVelocity, positions: np.ndarray
) -> np.ndarray:
    """Initial velocities by a function of one's own, (n, D); those that are no number refused."""
    v = motion.at(positions)
    if not np.isfinite(v).all():
        row = int(np.argmin(np.isfinite(v).all(axis=1)))
        place = ", ".join(f"{x:.6g}" for x in positions[row])
        with located(scene.case):
            raise CaseError(
                f"bodies.{scene.body_names[body]}.velocity: {motion.registered} returns "
                f"({', '.join(f'{each:g}' for each in v[row])}) at ({place})"
            )
    return v


def _velocity_gradients(scene: Scene, body: int, positions: np.ndarray) -> np.ndarray:
    """Gradient of the initial velocity, (n, D*D), by differences over half a cell."""
    L = np.empty((len(positions), scene.dimension, scene.dimension))
    for d in range(scene.dimension):
        step = np.zeros(scene.dimension)
        step[d] = 0.25 * scene.domain.frame.cell[d]
        ends = (velocities(scene, body, positions + side * step) for side in (1.0, -1.0))
        L[:, :, d] = np.subtract(*ends) / (2.0 * step[d])
    return L.reshape(len(positions), -1)


def _vary(scene: Scene, p: Particles, rows: slice, block: ParticleBlock) -> None:
    """Set spatially varying parameters, and the mass, state and stress that follow."""
    own = scene.materials.variations.of(block, scene.materials.body_material[block.body])
    if own is None:
        return
    p.own[rows], p.state[rows] = own.columns, own.state
    p.m[rows] = p.V0[rows] * own.density  # (4)
    if block.stresses is None and own.pressure.any():
        p.sigma[rows, :3] = -own.pressure[:, None]
