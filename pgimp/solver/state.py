"""The complete state of a simulation, as a checkpoint keeps it: taken out, checked and put back.

What is kept does not depend on the ranks: particles in canonical order, sums by plane. What can
be had again from the case, or only saves time (the window, the holes between rows), is not kept.
"""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pgimp.errors import DamagedError, UsageError
from pgimp.kernels.order import cell_numbers, locate
from pgimp.kernels.particles import Particles
from pgimp.kernels.sums import SUMS
from pgimp.mpi.collective import all_or_none

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene
    from pgimp.solver.simulation import Simulation

#: Sums by plane that a simulation keeps from step to step.
ACCUMULATORS = ("work", "impulse", "beyond", "grip_impulse", "escaped")

_MODEL = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def no_sums(scene: "Scene", planes: int) -> tuple[np.ndarray, ...]:
    """The `ACCUMULATORS` before the first step: zeros, (planes, ...)."""
    faces, constraints = len(scene.faces), len(scene.loads.constraints)
    leavers = (len(scene.body_names), SUMS) if scene.exits else (0, 0)
    shapes = ((), (faces, 3), (faces,), (constraints, 3), leavers)
    return tuple(np.zeros((planes, *shape)) for shape in shapes)


class State(BaseModel):
    """What a checkpoint says besides particles and sums: where the run is, and its records."""

    model_config = _MODEL

    step: int = Field(ge=0, le=2**53)
    time: float = Field(ge=0.0)
    dt: float = Field(ge=0.0)
    rate: float = Field(ge=0.0)
    count: int = Field(ge=1, le=2**53)
    lightest: float = Field(ge=0.0)
    clamped: int = Field(ge=0)
    held: int = Field(ge=0, default=0)
    first_energy: float | None
    last_line: float | None
    beyond: float = Field(ge=0.0)
    beyond_time: float = Field(ge=0.0)
    beyond_face: str

    @classmethod
    def of(cls, source: Any) -> Self:
        """State that a checkpoint holds.

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
    """A rank's particles in canonical order, a column at a time: a copy of one is made on asking.

    Parameters
    ----------
    sim : Simulation
        Whose particles; columns that the scene does not use are left out.

    Attributes
    ----------
    columns : dict of str to ndarray
        The columns as they are stored, in another order and with holes.
    order : ndarray of int64, shape (n,)
        Where in them the particles are.
    """

    def __init__(self, sim: "Simulation") -> None:
        self.order = sim.live()
        self.columns = {
            name: array
            for name, array in sim.particles._asdict().items()
            if array.size or not array.shape[1:]
        }

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column, (n, ...)."""
        return self.columns[name][self.order]

    def __iter__(self) -> Iterator[str]:
        """Go through the names of the columns."""
        return iter(self.columns)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self.columns)


def capture(sim: "Simulation") -> tuple[dict[str, Any], Ordered, dict[str, np.ndarray]]:
    """Take the state out of a simulation between two steps; collective.

    Returns
    -------
    state : dict
        The content of a `State`; of use on rank 0.
    rows : mapping of str to ndarray
        This rank's particles.
    whole : dict of str to ndarray
        Particles of each layer, and sums by plane; empty but on rank 0.
    """
    own = sim.owned_planes
    sums = [getattr(sim, name)[:own] for name in ACCUMULATORS]
    parts = sim.comm.gather((np.diff(sim.population.start), (sim.clamped, sim.held), sums))
    if parts is None:
        return {}, Ordered(sim), {}
    records = sim.diagnostic_sums
    state = State(
        step=sim.step,
        time=sim.time,
        dt=sim.dt,
        rate=sim.rate,
        count=sim.count,
        lightest=sim.lightest,
        clamped=sum(part[1][0] for part in parts),
        held=sum(part[1][1] for part in parts),
        first_energy=records.first_energy,
        last_line=records.last[0] if records.last else None,
        beyond=records.beyond[0],
        beyond_time=records.beyond[1],
        beyond_face=records.beyond[2],
    )
    whole = {"layers": np.concatenate([part[0] for part in parts]).astype(np.int64)}
    for i, name in enumerate(ACCUMULATORS):
        whole[name] = np.concatenate([part[2][i] for part in parts])
    if records.last:
        whole["last-impulse"], whole["last-force"] = records.last[1:]
    whole = {name: array for name, array in whole.items() if array.size}
    return state.model_dump(), Ordered(sim), whole


def restore(sim: "Simulation", source: Any) -> None:
    """Put the state of a checkpoint into a simulation whose scene is made; collective.

    Everything is checked before it is used: a file with the right checksums may still hold what
    no run has written.

    Parameters
    ----------
    sim : Simulation
        Of the same case, but for what a resume may change.
    source : CheckpointFile
        The checkpoint.

    Raises
    ------
    DamagedError
        On every rank, if it does not hold a state of this scene.
    UsageError
        On every rank, if frames are to have what it does not hold.
    """
    comm, scene = sim.comm, sim.scene
    state, layers = all_or_none(comm, lambda: _outline(sim, source), DamagedError)
    sim.count = state.count
    if comm.rank == 0:
        sim.clamped, sim.held = state.clamped, state.held
    sim.decompose(layers)
    first, end = sim.slab.first, sim.slab.first + sim.slab.layers
    edges = np.concatenate([[0], np.cumsum(layers)])
    particles = all_or_none(
        comm, lambda: _particles(sim, source, edges[first : end + 1]), DamagedError, UsageError
    )
    sim.settle(particles, int(edges[end] - edges[first]), edges[first : end + 1] - edges[first])

    own = sim.owned_planes
    planes = scene.frame.vertices[0] + scene.vertices - 1

    def sums() -> dict[str, np.ndarray]:
        found = {}
        for name in ACCUMULATORS:
            mine = getattr(sim, name)
            if mine.shape[1:] and 0 in mine.shape[1:]:
                continue
            found[name] = _whole(source, name, (planes, *mine.shape[1:]))[first : first + own]
        if state.last_line is not None:
            shape = (len(scene.faces) + len(scene.loads.constraints), 3)
            for name in ("last-impulse", "last-force") if shape[0] else ():
                found[name] = _whole(source, name, shape)
        return found

    found = all_or_none(comm, sums, DamagedError)
    for name in ACCUMULATORS:
        if name in found:
            getattr(sim, name)[:own] = found[name]
    records = sim.diagnostic_sums
    records.first_energy = state.first_energy
    records.beyond = (state.beyond, state.beyond_time, state.beyond_face)
    if state.last_line is not None:
        none = np.zeros((0, 3))
        last = (found.get("last-impulse", none), found.get("last-force", none))
        records.last = (state.last_line, *last)
    sim.clock.restore(state.step, state.time)
    sim.dt, sim.rate, sim.lightest = state.dt, state.rate, state.lightest


def _outline(sim: "Simulation", source: Any) -> tuple[State, np.ndarray]:
    """State and number of particles by layer, in agreement with each other and the scene."""
    state = State.of(source)
    frame = sim.scene.frame
    layers = _whole(source, "layers", (frame.vertices[0],))
    if (layers < 0).any() or (layers > source.count).any() or layers.sum() != source.count:
        raise DamagedError("its particles by layer do not add up")
    if source.count > state.count:
        raise DamagedError("it has more particles than the case began with")
    return state, layers


def _whole(source: Any, name: str, shape: tuple[int, ...]) -> np.ndarray:
    kind = np.dtype(np.int64 if name == "layers" else np.float64)
    if source.whole.get(name) != (kind, shape):
        raise DamagedError(f"it has no {name} of the scene's shape")
    array = source.read_whole(name)
    if not np.isfinite(array).all():
        raise DamagedError(f"its {name} has values that are no finite numbers")
    return array


def _particles(sim: "Simulation", source: Any, edges: np.ndarray) -> Particles:
    """Read this rank's particles; `edges` are the rows at which its layers begin, and the end."""
    scene, first = sim.scene, int(edges[0])
    n = int(edges[-1]) - first
    columns = scene.loads.columns
    expected = Particles.empty(0, scene.dimension, scene.origins, **columns)._asdict()
    particles = Particles.empty(max(n, 1), scene.dimension, scene.origins, **columns)
    for name, like in expected.items():
        if 0 in like.shape[1:]:
            continue
        if name == "origin" and name not in source.rows:
            raise UsageError(
                "output.fields: the displacement needs the initial positions, which the checkpoint "
                "does not hold because the run began without that field; leave it out, or begin "
                "anew with --overwrite"
            )
        if source.rows.get(name) != (like.dtype, like.shape[1:]):
            raise DamagedError(f"its particles have no {name} of the scene's shape")
        array = source.read(name, first, first + n)
        if not np.isfinite(array).all():
            raise DamagedError(f"the {name} of its particles has values that are no finite numbers")
        getattr(particles, name)[:n] = array
    if fault := _inconsistent(sim, particles, edges - first, n):
        raise DamagedError(fault)
    return particles


def _inconsistent(sim: "Simulation", p: Particles, start: np.ndarray, n: int) -> str:
    """Say what in particles cannot be of this scene; the step relies on all of it."""
    scene, frame = sim.scene, sim.scene.frame
    x = (p.x[:n] - frame.origin) * frame.inverse
    ranges = (
        ("x", x, 0.0, np.array(frame.cells, float)),
        ("body", p.body[:n], 0, len(scene.body_names) - 1),
        ("id", p.id[:n], 0, sim.count - 1),
        ("cell", p.cell[:n], 0, cell_numbers(frame.vertices) - 1),
        ("grip", p.grip[:n], 0, len(scene.loads.constraints)),
        ("patch", p.patch[:n], 0.0, np.inf),
    )
    for name, values, least, most in ranges:
        if ((values < least) | (values > most)).any():
            return f"the {name} of a particle is out of range"
    for name in ("m", "V0", "V"):
        if not (getattr(p, name)[:n] > 0.0).all():
            return f"the {name} of a particle is not above zero"
    layer = p._replace(layer=np.empty_like(p.layer), cell=np.empty_like(p.cell))
    locate(scene.shape, frame, layer, np.arange(n, dtype=np.int32), frame.vertices)
    place = sim.slab.first + np.repeat(np.arange(len(start) - 1), np.diff(start))
    if (p.layer[:n] != place).any() or (layer.layer[:n] != place).any():
        return "a particle is not in its layer"
    same = place[1:] == place[:-1]
    cell, number = np.diff(p.cell[:n]), np.diff(p.id[:n])
    if (same & ((cell < 0) | ((cell == 0) & (number <= 0)))).any():
        return "its particles are not in canonical order"
    return ""
