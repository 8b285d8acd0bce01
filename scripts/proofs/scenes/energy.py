"""Energy that a step is known to make or to lose, from what it does at the vertices."""

import contextlib
from unittest import mock

import numpy as np

from pgimp.kernels.data.record import RECORD
from pgimp.kernels.step.momentum import REST
from pgimp.solver import particle_groups, transfers
from pgimp.solver import step as stepping
from pgimp.solver.contact import base
from pgimp.solver.contact.surfaces.contact import SurfaceContact
from pgimp.solver.particle_groups import groups_of

#: Of a free vertex's velocity; what differs by more is held.
ROUNDING = 1e-9


class Seen:
    """Records of the vertices in one step on one rank, (n, RECORD).

    They are taken within the step: after it the window may be another one. `carried` is what
    vertices get of the velocity's variation that particles carry, in place of the momenta. `sums`
    are those of the particles before the momentum update, when `forcing` acts. `after` are
    velocities and accelerations as particles take them; `held` those, but of bodies in the initial
    configuration before they meet others: particles get just that change, and with what the grid
    loses by it no energy. Vertices are `active` that have mass, and whose velocities particles
    carry: others gain no more than the work, in whatever way they are held.
    """

    @contextlib.contextmanager
    def step(self):
        """Look at the vertices in the one step that is done meanwhile."""
        sum_particles, update = stepping.sum_particles, base.update_momentum
        take, exchange = particle_groups.grid_to_particles, SurfaceContact.exchange
        self.held = None

        def summed(rank, groups, loads, marked):
            v = rank.up_to_date().v.copy()
            rank.up_to_date().v[:] = 0.0
            sum_particles(rank, groups_of(rank), loads, False)
            if any(rank.scene.domain.periodic):
                transfers.finish_sums(rank, groups)
            self.carried = rank.grid.G.reshape(-1, RECORD).copy()
            rank.up_to_date().v[:] = v
            sum_particles(rank, groups, loads, marked)

        def updated(frame, field, faces, forcing, ledger, contact, part):
            if part != REST:
                self.sums, self.forcing = field.G.reshape(-1, RECORD).copy(), forcing
            update(frame, field, faces, forcing, ledger, contact, part)

        def exchanged(contact, rank, update):
            self.held = rank.grid.field.G.reshape(-1, RECORD).copy()
            exchange(contact, rank, update)

        def taken(setting, field, *rest):
            self.after = field.G.reshape(-1, RECORD).copy()
            self.held = self.after if self.held is None else self.held
            planes = np.repeat(field.active != 0, field.window.stride[0] // RECORD)
            self.active = planes & (self.sums[:, 0] > 0.0) & (self.after[:, 0] > 0.0)
            self.active[field.owned * field.window.stride[0] // RECORD :] = False
            if field.motion:
                each = field.window.extent[1] * field.window.extent[2]
                kept = np.repeat(field.motion.fields, each)
                self.active &= ~np.tile(kept, len(field.active))
            return take(setting, field, *rest)

        with (
            mock.patch.object(stepping, "sum_particles", summed),
            mock.patch.object(base, "update_momentum", updated),
            mock.patch.object(base.NoContact, "by_planes", False),  # all forces come first
            mock.patch.object(particle_groups, "grid_to_particles", taken),
            mock.patch.object(SurfaceContact, "exchange", exchanged),
        ):
            yield

    def accelerated(self):
        """Energy that particles gain from vertices held at a rate, above the work that is booked.

        Work is booked with the velocity V that a vertex is left with, the particles gain at most
        that of A with the velocity halfway between theirs, p_v/m, and what A makes of it.

        Held is what the update of a free vertex would give another velocity or acceleration: the
        slot `HELD` has one code for all vertices with several such components.
        """
        forcing, sums, G = self.forcing, self.sums[self.active], self.held[self.active]
        dt, m = forcing.dt, sums[:, :1]
        own, V, A = sums[:, 1:4] / m, G[:, 1:4], G[:, 5:8]
        free = np.where(m > forcing.mass_cutoff, sums[:, 5:8] / m + forcing.gravity, 0.0)
        off = np.abs(V - own - dt * free) + dt * np.abs(A - free)
        held = off > ROUNDING * (np.abs(own) + dt * np.abs(free))
        return dt * float((m * A * (own + 0.5 * dt * A - V))[held].sum())

    def unbalanced(self):
        """Energy that accelerations give to what particles carry, and that they never get.

        With carried momenta q_v the grid's energy grows by (p_v + q_v) A_v dt, the particles' by
        p_v A_v dt.
        """
        q, G = self.carried[self.active], self.after[self.active]
        return self.forcing.dt * float((q[:, 1:4] * G[:, 5:8]).sum())
