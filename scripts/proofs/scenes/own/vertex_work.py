"""Work in a step that only vertices know: of tractions, absorbing faces, weights of rings."""

import contextlib
from unittest import mock

import numpy as np

from pgimp.kernels.data.arguments import Forcing
from pgimp.kernels.data.record import ACCELERATION, FORCE, MASS, VELOCITY
from pgimp.kernels.grid.absorbing import REACTION
from pgimp.solver import particle_groups
from pgimp.solver import step as stepping


class VertexWork:
    """Work of one step on one rank, by NumPy from the vertices' sums and velocities.

    The force of a load is what the vertices' sums lack where its areas are zero. `loads` is the
    work of all of them, and `force` their sum (D,). `static` is the work of what absorbing faces
    hold since they began, `weight` that of gravity.
    """

    def __init__(self, sim):
        self.sim, self._seen = sim, False
        self.loads, self.static, self.weight = 0.0, 0.0, 0.0
        self.force = np.zeros(sim.scene.dimension)

    @contextlib.contextmanager
    def step(self):
        """Look at the vertices in the one step that is done meanwhile."""
        sum_particles, take = stepping.sum_particles, particle_groups.grid_to_particles
        forces = []

        def summed(rank, *words, **keys):
            p, found = rank.population.columns, rank.scene.interaction.loads.at(self.sim.time)
            areas = [(p.patch, each) for each in found.tractions]
            areas += [(p.surface, each) for each in found.surfaces]
            parts = []
            forces.clear()  # of sums with other velocities
            self.force[:] = 0.0
            for array, load in areas:
                area = array[:, load.column].copy()
                array[:, load.column] = 0.0
                sum_particles(rank, *words, **keys)
                array[:, load.column] = area
                parts.append(rank.grid.by_vertex(rank.grid.G)[..., FORCE : FORCE + 3].copy())
            sum_particles(rank, *words, **keys)
            whole = rank.grid.by_vertex(rank.grid.G)[..., FORCE : FORCE + 3]
            for (_, load), part in zip(areas, parts, strict=True):
                forces.append((whole - part, float(load.follows)))
                self.force += forces[-1][0].reshape(-1, 3).sum(axis=0)[: len(self.force)]

        def taken(setting, field, *rest):
            if not self._seen:  # the first of all configurations
                forcing = next(each for each in rest if isinstance(each, Forcing))
                self._look(forcing, forces)
            self._seen = True
            return take(setting, field, *rest)

        with (
            mock.patch.object(stepping, "sum_particles", summed),
            mock.patch.object(particle_groups, "grid_to_particles", taken),
        ):
            yield

    def _look(self, forcing, forces):
        rank, dt = self.sim.rank, forcing.dt
        records = rank.grid.by_vertex(rank.grid.G)
        v, a = (records[..., part : part + 3] for part in (VELOCITY, ACCELERATION))
        for force, follows in forces:
            used = (force != 0.0).any(axis=-1, keepdims=True)
            mean = np.where(used, v - 0.5 * dt * follows * a, 0.0)
            self.loads += dt * float((force * mean).sum())
        active = (rank.grid.active != 0)[:, None, None, None]
        m = np.where(active & (records[..., MASS] > 0.0), records[..., MASS], 0.0)
        moved = np.where(m[..., None] > 0.0, m[..., None] * v, 0.0)
        self.weight = dt * float((moved * np.array(forcing.gravity)).sum())
        if not rank.absorbing or rank.scene.domain.settling:
            return
        # Planes, rows and columns of the vertices, whose fields share the static force by mass.
        # Planes that are not owned are copies of others.
        m[m <= forcing.mass_cutoff] = 0.0
        m[rank.grid.owned :] = 0.0
        total = m.sum(axis=1)
        mean = (m[..., None] * v).sum(axis=1) / np.where(total > 0.0, total, 1.0)[..., None]
        lower = np.array(rank.grid.window.lower)
        for face in rank.absorbing.found.values():
            at = np.argwhere(total > 0.0) + lower
            if face.ring[1] > 0:
                at[:, 0] -= np.where(at[:, 0] >= face.ring[0], face.ring[1], 0)
            inside = ((at >= face.lower) & (at < face.lower + face.extent)).all(axis=1)
            if inside.any():
                rows = np.ravel_multi_index((at - face.lower)[inside].T, face.extent)
                held = face.values[rows, REACTION : REACTION + 3]
                self.static += dt * float((held * mean[total > 0.0][inside]).sum())
