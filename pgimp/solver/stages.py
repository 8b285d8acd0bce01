"""From a stage of a run to the next: state of particles and ledger, and changes.

All of it follows from the state at the end of a stage, which a checkpoint holds, and from the two
stages' cases. So it does not depend on whether the run was resumed there.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.checks.stages import reselects
from pgimp.case.gauges import flux_gauges
from pgimp.errors import CaseError, RunError
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.ledger import PLACES, TAKEN, Ledger
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.sums.sums import STRAIN, SUMS
from pgimp.physics.loads.surfaces import surface_width
from pgimp.scene.geometry import release, take_as_empty
from pgimp.scene.rigid.free_body import State
from pgimp.scene.scene import Scene
from pgimp.scene.wave_speeds import rest_rate
from pgimp.solver.decomposition import partition
from pgimp.solver.history.body_sums import sums_of_bodies
from pgimp.solver.loads.grips import STATES, Grips
from pgimp.solver.particle_groups import fastest
from pgimp.solver.start.arrivals import arrivals_of, coming
from pgimp.solver.start.settle import begin_settling
from pgimp.solver.start.start import Start
from pgimp.solver.start.warmup import warm_up
from pgimp.solver.state.vertex_motion import enter_motion
from pgimp.solver.time.clock import clock_of
from pgimp.solver.time.energy_watch import EnergyWatch
from pgimp.solver.time.stability import check_first_step

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.rank import Rank


def enter(now: Start, case: Case) -> Start:
    """Enter the next stage, after the last step of the one before; collective.

    Parameters
    ----------
    now : Start
        The end of the stage before.
    case : Case
        The stage.

    Raises
    ------
    RunError
        On every rank: a constraint that begins and contains no particle, a step that is too long.
    """
    rank, comm, records = now.rank, now.comm, now.diagnostic_sums
    old, new = now.scene, Scene(case)
    if old.materials.densest is not None:
        new.materials.weigh(old.materials.densest)
    take_as_empty(case, comm)
    new.interaction.rigid_bodies.measure(comm)
    warm_up(new, comm)

    rank.contact.conclude(rank)
    gone = set(case.staged.removed) - set(old.case.staged.removed)
    arrivals = arrivals_of(new, old, rank)
    if gone:
        bodies = [old.body_names.index(name) for name in gone]
        if rank.absorbing:
            rank.absorbing.remove(rank, bodies)
        taken = _remove(rank, bodies)
        records.removed = records.removed_so_far(old) + taken
    if new.case.materials != old.case.materials:
        order = rank.population.ordered
        before, after = (sums_of_bodies(rank, scene, order).sum(axis=0) for scene in (old, new))
        records.changed += float(after[STRAIN] - before[STRAIN])
        records.initial_losses[: new.materials.sums - SUMS] += after[SUMS:] - before[SUMS:]
    particles = _carried(rank, old, new)
    for name in ("last", "read"):
        if since := getattr(records, name):
            time, *parts = since
            impulse, force = (_rows(_forces(old), _forces(new), part) for part in parts)
            setattr(records, name, (time, impulse, force))

    counts = np.concatenate(comm.allgather(np.diff(rank.population.start)))
    _, balance, _ = partition(new, comm, counts + arrivals.layers if arrivals else counts)
    if balance.cuts != now.balance.cuts:
        rank.population.replace(particles)
        rank.move(now.balance.cuts, balance.cuts)
        particles = rank.up_to_date()
    balance.watch(rank.count)
    books, free, before, slaves = rank.booked(), dict(_free(rank)), rank.grid, rank.slaves
    grips = _grips(rank.grips, old, new)
    rank.enter(new, particles)
    _take_over(old, new, books, rank.booked())
    if rank.free:
        rank.free.states = [free[name] for name, _ in _free(rank)]
    enter_motion(rank, before, slaves)
    if rank.grips:
        rank.grips.start(rank, grips)
    if arrivals:
        arrivals.enter(now)
        particles = rank.up_to_date()

    now.stage, now.scene, now.balance = now.stage + 1, new, balance
    rate = fastest(new, particles, rank.population.order, new.settings.controlled or True)
    now.rate = max(now.rate, *comm.allgather(rate))
    rate = max(rest_rate(new, body) for body in range(len(new.body_names)))
    if new.materials.variations:  # as in `Simulation`
        rate = now.rate
    same = isinstance(case.time.step, float | int) and case.time.step == old.case.time.step
    same = same and not (case.rests or old.case.rests)  # whose steps take no time
    now.clock = clock_of(case, rate, now.clock.before if same else now.done.number)
    _watch(now, rate * min(new.domain.frame.cell))
    if new.settings.settles:
        begin_settling(now)
        if now.watch and not case.watched:
            now.watch.begin(rank)
    try:
        dt = now.clock.next(now.done, rank.fastest(now.rate)).dt
        now.warnings += check_first_step(new, dt, max(now.rate, rank.parts_rate))
    except CaseError as error:
        raise RunError(f"{case.staged.title}: {error}") from None
    release(case)  # where bodies meet their surfaces are needed
    return now


def _remove(rank: Rank, bodies: list[int]) -> np.ndarray:
    """Remove all particles of some bodies; return their sums, of use on rank 0."""
    population = rank.population
    order = population.order
    offsets = np.flatnonzero(np.isin(rank.up_to_date().body[order], bodies)).astype(np.int32)
    rows = order[offsets]
    start = np.searchsorted(offsets, population.start)
    taken = sums_of_bodies(rank, rank.scene, Order(rows, start), bodies)
    population.free_later(rows)
    population.restore_order(offsets, np.empty(0, np.int32))
    return np.add.reduce(taken, axis=0)


def _carried(rank: Rank, old: Scene, new: Scene) -> Particles:
    """The particles with the columns of the next stage; new columns are zero."""
    p, rows = rank.up_to_date(), rank.live()
    arrays = {}
    for name, like in Particles.empty(0, new.carried)._asdict().items():
        array = getattr(p, name)
        shape = like.shape[1:]
        same = array.shape[1:] == shape
        arrays[name] = array if same else np.zeros((p.capacity, *shape), like.dtype)
    names = [scene.interaction.loads.on_faces for scene in (old, new)]
    if names[0] != names[1]:
        kept = [names[0].index(name) for name in names[1]]
        arrays["patch"] = np.ascontiguousarray(p.patch[:, kept])
    names = [list(scene.interaction.loads.surfaces.entries) for scene in (old, new)]
    if names[0] != names[1]:
        kept, width = [names[0].index(name) for name in names[1]], surface_width(new.dimension)
        parts = p.surface.reshape(p.capacity, -1, width)[:, kept]
        arrays["surface"] = np.ascontiguousarray(parts.reshape(p.capacity, len(kept) * width))
        if wide := new.carried.bearing:
            parts = p.bearing.reshape(p.capacity, -1, wide)[:, kept]
            arrays["bearing"] = np.ascontiguousarray(parts.reshape(p.capacity, len(kept) * wide))
    if old.case.constraints or new.case.constraints:
        found = _held(rank, old.case, new)
        if new.case.constraints:
            arrays["constraint"][rows, 0] = found
    return Particles(**arrays)


def _held(rank: Rank, before: Case, new: Scene) -> np.ndarray:
    """Number of the constraint that holds each particle, in canonical order; collective.

    Existing constraints keep their particles; of several the last one holds.
    """
    p, rows = rank.up_to_date(), rank.live()
    had = p.constraint[rows, 0] if p.constraint.shape[1] else np.zeros(len(rows), np.int32)
    number = {name: i for i, name in enumerate(before.constraints, 1)}
    found = np.zeros(len(rows), np.int32)
    new_ones = []
    for i, (name, entry) in enumerate(new.case.constraints.items(), 1):
        if reselects(before, new.case, name):
            mine = np.flatnonzero(p.body[rows] == new.body_names.index(entry.body))
            mine = mine[entry.region.contains(p.x[rows[mine]])]
            new_ones.append((i, name, entry.body))
        else:
            mine = np.flatnonzero(had == number[name])
        found[mine] = i
    counts = np.bincount(found, minlength=len(new.case.constraints) + 1)
    counts = np.sum(rank.comm.allgather(counts), axis=0)
    for i, name, body in new_ones:
        if not counts[i] and body not in {*new.case.staged.awaited, *coming(before, new.case)}:
            raise RunError(
                f"{new.case.staged.title}: constraints.{name}.region contains no particle of body "
                f"'{body}' as the stage begins\n"
                "  try: another region; the checkpoint of the stage before is intact"
            )
    return found


def _forces(scene: Scene) -> list[Hashable]:
    """Names of the rows of `Diagnostics.last`, in their order."""
    faces, constraints, tractions, contact, rigid_bodies = _booked(scene)
    gauges = flux_gauges(scene.case.gauges)
    fluxes: list[Hashable] = [(name, i) for name in gauges for i in range(2)]
    kinds = {
        "face": faces,
        "constraint": constraints,
        "traction": tractions,
        "contact": contact,
        "place": _placed(scene, contact),
        "flux": fluxes,
        "impulse": rigid_bodies,
        "moment": rigid_bodies,
    }
    return [(kind, name) for kind, names in kinds.items() for name in names]


def _booked(scene: Scene) -> tuple[list[Hashable], ...]:
    """Names of faces, constraints, tractions, entries of contact and rigid bodies in the ledger."""
    # The last law of contact is for pairs without an entry.
    contact: list[Hashable] = []
    if scene.interaction.pairs:
        contact = [*(entry.name for entry in scene.case.contact), ""]
    faces: list[Hashable] = [face.name for face in scene.domain.faces]
    loads = scene.interaction.loads
    held, pulled = loads.booked_constraints, loads.booked_tractions
    return faces, held, pulled, contact, list(scene.interaction.rigid_bodies.names)


def _placed(scene: Scene, contact: list[Hashable]) -> list[Hashable]:
    """Names of the rows of `Ledger.contact_moments`."""
    places = PLACES * scene.settings.by_vertex
    return [(name, row) for name in contact for row in range(places)]


def _rows(old: Sequence[Hashable], new: Sequence[Hashable], values: np.ndarray) -> np.ndarray:
    """Reorder rows to new names, zero-filled."""
    number = {name: i for i, name in enumerate(old)}
    found = np.zeros((len(new), *values.shape[1:]))
    for i, name in enumerate(new):
        if name in number:
            found[i] = values[number[name]]
    return found


def _take_over(old: Scene, new: Scene, had: Ledger, has: Ledger) -> None:
    """Copy the ledger into the ledger of the next stage."""
    faces, constraints, tractions, contact, rigid_bodies = zip(
        _booked(old), _booked(new), strict=True
    )
    kinds = {
        "impulse": faces,
        "outside_mass": faces,
        "constraint_impulse": constraints,
        "traction_impulse": tractions,
        "wall_energy": faces,
        "contact": contact,
        "contact_moments": (_placed(old, contact[0]), _placed(new, contact[1])),
        "rigid_bodies": rigid_bodies,
    }
    for name, (before, after) in kinds.items():
        by_name = np.moveaxis(getattr(had, name), 1, 0)
        getattr(has, name)[:] = np.moveaxis(_rows(before, after, by_name), 0, 1)
    has.work[:] = had.work
    if had.escaped.size:
        has.escaped[:] = had.escaped
    if had.crossed.size:
        has.crossed[:] = had.crossed
    if had.damping.size and has.damping.size:
        has.damping[:, :TAKEN] = had.damping[:, :TAKEN]


def _grips(grips: Grips | None, old: Scene, new: Scene) -> np.ndarray:
    """States of the next stage's grips: what those that stay have, zeros else."""
    case = new.case
    had = np.zeros((len(old.case.constraints), STATES, 3)) if grips is None else grips.state
    names = [name if not reselects(old.case, case, name) else None for name in case.constraints]
    return _rows(list(old.case.constraints), names, had)


def _free(rank: Rank) -> list[tuple[str, State]]:
    """The free rigid bodies, by name, and their states."""
    if rank.free is None:
        return []
    names = [
        rank.scene.interaction.rigid_bodies.names[number]
        for number in rank.scene.interaction.rigid_bodies.free
    ]
    return list(zip(names, rank.free.states, strict=True))


def _watch(now: Start, speed: float) -> None:
    """Watch the energy from here on, if pgimp chooses the stage's steps; its numbers stay."""
    before, now.watch = now.watch, None
    if not now.case.watched:
        return
    now.watch = EnergyWatch(speed, now.case.method.stress)
    if before:
        now.watch.numbers = before.numbers
    if now.rank.slaves:
        now.watch.part = min(now.watch.part, now.rank.slaves.part)
    now.watch.begin(now.rank)
    now.watch.shorten(now.clock)
