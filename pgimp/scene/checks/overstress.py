"""Initial stress of particles beyond the strength of their material, which the first step cuts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pgimp.geometry.regions import Points
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.once.prestress import bearable_stress, remember_stress
from pgimp.mpi.communicator import Communicator
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.bodies.populate import prestressed, set_stress
from pgimp.scene.checks.warned import Warned, warned
from pgimp.scene.scene import Scene

#: Part of a particle's greatest stress that is rounding of the strength.
_ROUNDING = 1e-6


def yielding(scene: Scene) -> list[int]:
    """Plastically flowing bodies that begin with a stress: from a file, or of the weight above."""
    if scene.case.start.stress is None:
        return stressed(scene)
    bodies = enumerate(scene.case.bodies.values())
    return [n for n, body in bodies if "plastic-work" in scene.case.materials[body.material].LOSSES]


def stressed(scene: Scene) -> list[int]:
    """Plastically flowing bodies whose particles begin with the stress from a file."""
    return [
        number
        for number, body in enumerate(scene.case.bodies.values())
        if isinstance(body.region, Points)
        and body.region.summary.stress
        and not body.region.summary.saved  # which bore it
        and "plastic-work" in scene.case.materials[body.material].LOSSES
    ]


def measure(scene: Scene, particles: Particles, count: int, comm: Communicator) -> list[Warned]:
    """Return a warning for each body whose stress the material cuts; collective.

    Parameters
    ----------
    particles : Particles
        The rank's particles, which store their stress; the first `count` are examined.
    """
    found: list[Warned] = []
    for body in yielding(scene):
        rows = np.flatnonzero(particles.body[:count] == body)
        found += _warnings(scene, body, comm.allgather(_cut(scene, particles, rows)))
    return found


def foresee(scene: Scene, lattice: Lattice, counts: np.ndarray) -> Iterator[Warned]:
    """Yield the warnings of `measure` before particles exist, a block at a time."""
    memory = prestressed(scene)
    for body in stressed(scene):
        parts = []
        for block in lattice.make((0, lattice.planes), counts, body):
            n = len(block.ids)
            p = Particles.empty(max(n, 1), scene.carried)
            p.body[:] = body
            p.V0[:] = 0.0
            set_stress(scene, p, slice(0, n), block)
            rows = np.arange(n)
            if body in memory:
                remember_stress(scene.setting.without_shape(), p, rows)
            parts.append(_cut(scene, p, rows))
        yield from _warnings(scene, body, parts)


def _cut(scene: Scene, particles: Particles, rows: np.ndarray) -> tuple[int, int, float, float]:
    """Number of particles, number of cut ones, greatest relative loss, and greatest loss."""
    if not len(rows):
        return 0, 0, 0.0, 0.0
    before = particles.sigma[rows]
    after = np.empty_like(before)
    bearable_stress(scene.setting.without_shape(), particles, rows, after)
    size, lost = np.abs(before).max(axis=1), np.abs(after - before).max(axis=1)
    cut = lost > _ROUNDING * size
    part = lost[cut] / size[cut]
    return (
        len(rows),
        int(cut.sum()),
        float(part.max(initial=0.0)),
        float(lost[cut].max(initial=0.0)),
    )


def _warnings(
    scene: Scene, body: int, parts: Sequence[tuple[int, int, float, float]]
) -> Iterator[Warned]:
    every, cut = sum(part[0] for part in parts), sum(part[1] for part in parts)
    if cut:
        share, most = max(part[2] for part in parts), max(part[3] for part in parts)
        name = scene.body_names[body]
        material = scene.case.bodies[name].material
        where, source = f"bodies.{name}.region", "particles of the file"
        if scene.case.start.stress is not None:
            where, source = "start.stress", f"particles of '{name}'"
        yield warned(
            "overstress",
            f"{where}: the stress of {cut:,} of {every:,} {source} is "
            f"beyond the strength of '{material}' and is cut in the first step, a component by up "
            f"to {most:.3g}, {100.0 * share:.2g} % of a particle's greatest; give stresses that "
            "it bears, or more strength",
        )
