"""The complete state of a simulation in a checkpoint; `restore` puts it back.

It does not depend on the ranks: particles in canonical order, sums by plane. Data that follow from
the case, or only save time (the window, the holes between rows), are left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, NonNegativeFloat, ValidationError

from pgimp.errors import DamagedError
from pgimp.physics.materials.base import LOSSES
from pgimp.solver.damping.relaxation import Relaxation
from pgimp.solver.history.diagnostics import Diagnostics
from pgimp.solver.lagrangian.pieces import source_at
from pgimp.solver.rank import Rank
from pgimp.solver.state.contact import BEARING, FIELDS, FORCES, LOADS, SEARCH
from pgimp.solver.state.stored_motion import MOTION, MOTION_PLANES, stored_motion
from pgimp.solver.time.clock import CourantClock, FixedClock, Step
from pgimp.solver.time.energy_watch import EnergyWatch

if TYPE_CHECKING:
    from pgimp.io.checkpoints.checkpointfile import CheckpointFile

_MODEL = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


class State(BaseModel):
    """Header of a checkpoint besides particles and sums: progress of the run, and its records."""

    model_config = _MODEL

    step: int = Field(ge=0, le=2**53)
    time: float = Field(ge=0.0)
    dt: float = Field(ge=0.0)
    rate: float = Field(ge=0.0)
    count: int = Field(ge=1, le=2**53)
    mass_cutoff: float = Field(ge=0.0)
    clamped: int = Field(ge=0)
    held: int = Field(ge=0, default=0)
    fallbacks: int = Field(ge=0, default=0)
    first_energy: float | None
    last_line: float | None
    beyond: float = Field(ge=0.0)
    beyond_time: float = Field(ge=0.0)
    beyond_face: str
    rigid_bodies: str = ""
    densest: float | None = Field(default=None, gt=0.0)
    watch: list[float] | None = Field(default=None, min_length=4, max_length=12)
    held_rate: list[NonNegativeFloat] | None = Field(default=None, min_length=7, max_length=7)
    stage: int = Field(ge=0, le=1000, default=0)
    settling: bool = False
    counted: int = Field(ge=0, le=2**53, default=0)
    removed: list[float] | None = Field(default=None, max_length=100)
    added: list[float] | None = Field(default=None, max_length=100)
    inflow: list[float] | None = Field(default=None, max_length=300)
    each: dict[str, dict[str, Any]] | None = None
    changed: float = 0.0
    settling_time: float = Field(ge=0.0, default=0.0)
    relaxation: list[float] | None = Field(default=None, min_length=4, max_length=5)
    initial_losses: list[float] = Field(
        default=[0.0] * len(LOSSES), min_length=len(LOSSES), max_length=len(LOSSES)
    )

    @classmethod
    def of(cls, source: CheckpointFile) -> Self:
        """State in a checkpoint.

        Raises
        ------
        DamagedError
            If it holds none.
        """
        try:
            return cls.model_validate(source.about.get("state"))
        except ValidationError as error:
            first = error.errors()[0]
            name = ".".join(map(str, first["loc"])) or "state"
            raise DamagedError(f"its {name} is not what it must be: {first['msg']}") from None


class Ordered(Mapping[str, np.ndarray]):
    """A rank's particles in canonical order, up to date; a column is copied when it is asked for.

    Parameters
    ----------
    rank : Rank
        The rank of the particles; columns that the scene does not use are left out.

    Attributes
    ----------
    columns : dict of str to ndarray
        The stored columns, in another order and with holes; but see `at`.
    order : ndarray of int64, shape (n,)
        Rows of the particles in the columns.
    """

    def __init__(self, rank: Rank) -> None:
        self._rank, self.order = rank, rank.live()
        population = rank.population
        particles = population.columns if population.released else population.up_to_date()
        self.columns = {
            name: array
            for name, array in particles._asdict().items()
            if array.size or not array.shape[1:]
        }

    def at(self, rows: np.ndarray) -> Mapping[str, np.ndarray]:
        """Columns at some rows in place of those stored, until the next call."""
        return source_at(self._rank, rows).instead

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column, (n, ...)."""
        instead = self.at(self.order)
        return instead[name].copy() if name in instead else self.columns[name][self.order]

    def __iter__(self) -> Iterator[str]:
        """Go through the names of the columns."""
        return iter(self.columns)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self.columns)


def capture(
    rank: Rank,
    done: Step,
    rate: float,
    count: int,
    records: Diagnostics,
    watch: EnergyWatch | None = None,
    stage: int = 0,
    clock: FixedClock | CourantClock | None = None,
    settling: bool = False,
    each: dict[str, dict[str, Any]] | None = None,
) -> tuple[dict[str, object], Ordered, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Capture the state of a simulation between two steps; collective.

    Parameters
    ----------
    done : Step
        The last step.
    rate : float
        Largest (c_p + |v_p|)/L of all ranks.
    count : int
        Particles that all ranks have had so far.
    records : Diagnostics
        State of the history from line to line.
    watch : EnergyWatch, optional
        The guard of the steps.
    stage : int
        Its number.
    clock : FixedClock or CourantClock, optional
        Its clock.
    settling : bool
        Whether the run still comes to rest before time 0.
    each : dict, optional
        State and loads of a function that is called after steps.

    Returns
    -------
    state : dict
        The content of a `State`; of use on rank 0.
    rows : mapping of str to ndarray
        This rank's particles.
    whole : dict of str to ndarray
        Particles of each layer, and sums by plane; empty except on rank 0.
    spread : dict of str to ndarray
        This rank's vertices that keep their motion; empty arrays in other scenes.
    """
    own, kinematics = rank.booked(), rank.surface_kinematics
    vertices, *motion = stored_motion(rank)
    parts = rank.comm.gather(
        (
            np.diff(rank.population.start),
            (rank.clamped, rank.held, kinematics.fallbacks if kinematics else 0),
            own,
            vertices,
            rank.contact.kept_forces,
            rank.contact.search,
            rank.contact.surface_loads,
        )
    )
    if parts is None:
        return {}, Ordered(rank), {}, dict(zip(MOTION, motion, strict=True))
    state = State(
        step=done.number,
        time=done.end,
        dt=done.dt,
        rate=rate,
        count=count,
        mass_cutoff=rank.mass_cutoff,
        clamped=sum(part[1][0] for part in parts),
        held=sum(part[1][1] for part in parts),
        fallbacks=sum(part[1][2] for part in parts),
        first_energy=records.first_energy,
        last_line=records.last[0] if records.last else None,
        beyond=records.most_outside[0],
        beyond_time=records.most_outside[1],
        beyond_face=records.most_outside[2],
        rigid_bodies=rank.scene.interaction.rigid_bodies.checksum,
        densest=rank.scene.materials.densest,
        watch=watch.numbers if watch else None,
        stage=stage,
        settling=settling,
        counted=clock.before if clock else 0,
        held_rate=clock.held.numbers if clock and clock.held else None,
        removed=None if records.removed is None else records.removed.tolist(),
        added=None if records.added is None else records.added.tolist(),
        inflow=rank.inflow.numbers if rank.inflow else None,
        each=each,
        changed=records.changed,
        settling_time=records.settling_time,
        relaxation=rank.damping.numbers if isinstance(rank.damping, Relaxation) else None,
        initial_losses=records.initial_losses.tolist(),
    )
    layers, extra = rank.scene.domain.frame.vertices[0], rank.scene.settings.vertices - 1
    before = rank.scene.domain.ring or 0

    def by_layer(parts: Sequence[np.ndarray], count: int) -> np.ndarray:
        """Join the ranks' parts; layers and planes outside of a ring have none."""
        found = np.concatenate(parts)
        if not before or not len(found):
            return found
        more = np.zeros((count, *found.shape[1:]), found.dtype)
        more[before : before + len(found)] = found
        return more

    whole: dict[str, np.ndarray] = {
        "layers": by_layer([part[0] for part in parts], layers).astype(np.int64)
    }
    for i, name in enumerate(own.datasets()):
        whole[name] = by_layer([part[2][i] for part in parts], layers + extra)
    if rank.free:
        whole["free-bodies"] = np.array([state.numbers for state in rank.free.states])
    if rank.grips:
        whole["grips"] = rank.grips.state
    if rank.averaged_mass:
        whole[BEARING] = rank.averaged_mass.state
    if rank.absorbing:
        whole |= rank.absorbing.datasets()
    whole[FIELDS] = rank.contact.assignment
    whole[FORCES] = np.concatenate([part[4] for part in parts])
    whole[SEARCH] = np.concatenate([part[5] for part in parts])
    whole[LOADS] = max((part[6] for part in parts), key=len)
    whole["gauge-lines"] = records.means.rows(rank.scene)
    if records.last:
        whole["last-impulse"], whole["last-force"] = records.last[1:]
    whole[MOTION_PLANES] = by_layer([part[3] for part in parts], layers + extra)
    whole = {name: array for name, array in whole.items() if array.size}
    return state.model_dump(), Ordered(rank), whole, dict(zip(MOTION, motion, strict=True))
