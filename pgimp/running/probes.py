"""Files of the probes, ``probes/NAME.csv``, and their records in a checkpoint."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from pgimp.case.output import PlaceProbe, PointProbe
from pgimp.errors import RunError, UsageError, explain
from pgimp.io.rundir.probefiles import PROBES, probe_file
from pgimp.mpi.collective import on_root
from pgimp.running.schedule import Schedule
from pgimp.solver.state.probes import Place, Point, begin_at_rest, nearest, sample
from pgimp.storage.atomic import sync_folder
from pgimp.storage.lines import LineFile

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.simulation import Simulation

_Place = Annotated[list[float], Field(min_length=1, max_length=3)]


class Record(BaseModel):
    """Record of a probe in a checkpoint."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    body: str | None  #: Body in the case; None for a fixed position.
    at: _Place  #: list of float: Position in the case.
    #: number, origin: int, list of float: Id of the followed particle, and where its displacement
    #: counts from; -1 and `at` for a fixed position.
    number: int = Field(ge=-1, le=2**53)
    origin: _Place
    line: int = Field(ge=-1, le=2**53)  #: Step of the last line that is safe on disk.
    #: Number of lines up to it; None if unknown.
    lines: int | None = Field(default=None, ge=0, le=2**53)
    fields: list[str] = Field(default=[], max_length=100)  #: Derived fields in further columns.


#: A probe in the case.
Probe = PointProbe | PlaceProbe


def _what(entry: Probe) -> tuple[str | None, list[float]]:
    """Body and position of a probe in the case."""
    if isinstance(entry, PlaceProbe):
        return None, list(entry.place)
    return entry.body, list(entry.at)


def require_known(case: Case, records: Mapping[str, Record]) -> None:
    """Ensure that the probes of a case can continue from their records in a checkpoint.

    Raises
    ------
    UsageError
        If a probe's particle no longer exists, or has changed.
    """
    for name, entry in case.probes.items():
        body, at = _what(entry)
        record = records.get(name)
        if record is None and body is not None:
            raise UsageError(
                f"probes.{name}: the run began without it, and which particle was closest to the "
                "place at the start is not known any more; leave it out, or start over "
                "with --overwrite"
            )
        if record is not None and (record.body, record.at) != (body, at):
            raise UsageError(
                f"probes.{name}: the run began with another probe of this name; take another name "
                "for the new one"
            )
        if record is not None and record.fields != list(entry.fields):
            raise UsageError(
                f"probes.{name}.fields: the run began with other columns; take another name for "
                "the new ones"
            )


class _Probe(NamedTuple):
    """A probe of the case, its target, and its file."""

    entry: Probe
    target: Point | Place
    file: LineFile

    def record(self) -> Record:
        """Record for a checkpoint."""
        body, at = _what(self.entry)
        number, origin = -1, at
        if isinstance(self.target, Point):
            number, origin = self.target.number, list(self.target.origin)
        return Record(
            body=body,
            at=at,
            number=number,
            origin=origin,
            line=self.file.step,
            lines=self.file.count,
            fields=list(self.entry.fields),
        )


def _schedules(case: Case) -> list[tuple[Schedule, list[str]]]:
    """Schedules of probes' lines, each with the names of its probes."""
    times: dict[object, list[str]] = {}
    for name, entry in case.probes.items():
        times.setdefault(entry.every or case.history.every, []).append(name)
    return [(Schedule(every), names) for every, names in times.items()]


class Probes:
    """Writes the lines of all probes of a run.

    Parameters
    ----------
    case : Case
        The case with the probes.
    """

    def __init__(self, directory: Path, case: Case, sim: Simulation) -> None:
        self._directory = directory
        self._case, self._sim = case, sim
        self._probes: dict[str, _Probe] = {}
        self._schedules = _schedules(case)

    def choose(self, records: Mapping[str, Record]) -> None:
        """Find the followed particles of a run that has yet to settle; collective.

        Parameters
        ----------
        records : mapping of str to Record
            Those that a checkpoint of the settling has; see `require_known`.

        Raises
        ------
        RunError
            On every rank, if their folder cannot be made.
        """
        self._open(records)

    def begin(self) -> None:
        """Find the followed particles, if need be, and write the initial lines; collective.

        Raises
        ------
        RunError
            On every rank, if that is not possible; later methods raise it likewise.
        """
        if self._probes:
            targets = [probe.target for probe in self._probes.values()]
            begin_at_rest(self._sim, [each for each in targets if isinstance(each, Point)])
        else:
            self._open({})
        self.write()

    def resume(self, records: Mapping[str, Record]) -> list[str]:
        """Continue after the lines that a checkpoint records; collective.

        Parameters
        ----------
        records : mapping of str to Record
            Records of the probes, checked by `require_known`.

        Returns
        -------
        list of str
            Messages on missing earlier lines.
        """
        sim, notes = self._sim, []
        self._open(records)
        for name, probe in self._probes.items():
            if name not in records:  # existing lines of an earlier probe of this name stay
                probe.file.resume(sim.comm, sim.step)
                continue
            line = records[name].line
            probe.file.resume(sim.comm, line)
            if probe.file.step != line:
                notes.append(
                    f"{probe.file.path} ends at step {probe.file.step}, but it had a line of step "
                    f"{line}: lines are missing"
                )
        for schedule, _ in self._schedules:
            schedule.skip(sim.time, sim.step, sim.dt)
        return notes

    def enter(self, case: Case) -> None:
        """Continue in another stage of the case, whose history may have other times."""
        sim = self._sim
        self._schedules = _schedules(case)
        for schedule, _ in self._schedules:
            schedule.skip(sim.time, sim.step, sim.dt)

    def _open(self, records: Mapping[str, Record]) -> None:
        for name, entry in self._case.probes.items():
            body, at = _what(entry)
            target: Point | Place
            if body is None:
                target = Place(at, entry.fields)
            elif name in records:
                target = Point(records[name].number, records[name].origin, entry.fields, at)
            else:
                number = self._sim.scene.body_names.index(body)
                target = nearest(self._sim, number, at, entry.fields)
            self._probes[name] = _Probe(entry, target, LineFile(probe_file(self._directory, name)))
        if self._probes:
            on_root(self._sim.comm, self._make_folder)

    def _make_folder(self) -> None:
        folder = self._directory / PROBES
        try:
            folder.mkdir(exist_ok=True)
            sync_folder(self._directory)
        except OSError as error:
            raise RunError(f"cannot make {folder}: {explain(error)}") from error

    def due(self) -> list[str]:
        """Names of the probes whose lines are due; call it once after each step."""
        sim = self._sim
        return [
            name
            for schedule, names in self._schedules
            if schedule.due(sim.time, sim.step, sim.dt)
            for name in names
        ]

    def write(self, names: Iterable[str] | None = None) -> None:
        """Write lines of some or all probes, unless they exist for this step; collective."""
        sim = self._sim
        due = [self._probes[name] for name in (self._probes if names is None else names)]
        due = [probe for probe in due if probe.file.step != sim.step]
        if not due:
            return
        lines = sample(sim, [probe.target for probe in due])
        for probe in due:
            probe.file.step = sim.step

        def append() -> None:
            for probe, line in zip(due, lines, strict=True):
                probe.file.append(line)

        on_root(sim.comm, append)

    def sync(self) -> None:
        """Ensure that the lines so far survive a crash of the machine; on rank 0."""
        for probe in self._probes.values():
            probe.file.sync()

    def records(self) -> dict[str, Record]:
        """Records for a checkpoint, by name."""
        return {name: probe.record() for name, probe in self._probes.items()}

    def close(self) -> None:
        """Close the files."""
        for probe in self._probes.values():
            probe.file.close()
