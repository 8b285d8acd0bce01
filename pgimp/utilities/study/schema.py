"""The study file as typed models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, model_validator

from pgimp.schema.base import Count, Label, Model, Positive
from pgimp.schema.dispatch import Either
from pgimp.schema.messages import describe, got, unknown
from pgimp.schema.problems import Problem, problem, raise_problems
from pgimp.utilities.study.bisect_entry import Bisection
from pgimp.utilities.study.measure_entry import LIMIT, AnyMeasure, Measure, Text, measure_of

CASE = "case"
"""The one swept key that is none of the case: it names the case's file."""

MOST_RUNS = 10_000

COSTS = {
    "wall": "wall time of the steps, without set-up and output [s]",
    "core": "wall time times ranks [s]",
    "particle-steps": "particles times steps",
    "steps": "steps",
}
"""What ``cost`` may name."""


def _format(value: int) -> int:
    if value != 1:
        raise problem(f"this pgimp reads studies of format 1, got {value}")
    return value


def _cost(value: str) -> str:
    if value not in COSTS:
        raise problem(unknown("measure of cost", value, COSTS))
    return value


def _launcher(value: tuple[str, ...]) -> tuple[str, ...]:
    if not value[0].strip():
        raise problem("the first word is the program that starts the ranks, such as mpirun")
    return value


def _changes(changes: Mapping[str, object], path: tuple[str | int, ...] = ()) -> Iterator[Problem]:
    """Check that every key is a path of keys, and that none overrides an earlier one."""
    seen: list[str] = []
    for key in changes:
        if not all(key.split(".")):
            yield Problem((*path, key), "expected keys joined by dots, such as grid.cell")
        elif over := next((one for one in seen if f"{one}.".startswith(f"{key}.")), None):
            yield Problem((*path, key), f"would undo {over}, which stands before it; put it first")
        seen.append(key)


def _set(value: dict[str, object]) -> dict[str, object]:
    raise_problems("set", _changes(value), value)
    return value


def is_named(entry: Mapping[str, object]) -> bool:
    """Whether an entry of the sweep has sets of changes by name, not lists by key."""
    return all(isinstance(value, dict) for value in entry.values())


def _entry(entry: dict[str, Any], number: int) -> Iterator[Problem]:
    """Check one entry of the sweep."""
    if not entry:
        yield Problem((number,), "expected a key with a list of values, such as {grid.cell: [..]}")
    elif is_named(entry):
        for name, changes in entry.items():
            yield from _changes(changes, (number, name))
        return
    for key, value in entry.items():
        if not isinstance(value, list | tuple):
            expected = "expected a list, a value a run"
            if isinstance(value, dict):
                expected += ", or a mapping of changes for every name of the entry"
            yield Problem((number, key), f"{expected}, {got(value)}")
        elif not value:
            yield Problem((number, key), "expected at least one value, got an empty list")
        else:
            first, values = next(iter(entry.items()))
            if isinstance(values, list | tuple) and len(value) != len(values):
                text = f"keys of one entry change together, but there are {len(values)} values of "
                yield Problem((number, key), f"{text}{first} and {len(value)} here")
    yield from _changes(entry, (number,))


def _sweep(entries: tuple[dict[str, Any], ...]) -> tuple[dict[str, Any], ...]:
    found = [item for number, entry in enumerate(entries) for item in _entry(entry, number)]
    raise_problems("sweep", found, entries)
    runs = 1
    for entry in entries:
        runs *= len(entry) if is_named(entry) else len(next(iter(entry.values())))
    if runs > MOST_RUNS:
        raise problem(f"{runs} runs are too many (at most {MOST_RUNS})")
    return entries


def _unique(values: tuple[str, ...]) -> tuple[str, ...]:
    for position, value in enumerate(values):
        if value in values[:position]:
            raise_problems("list", [Problem((position,), f"{value} is in the list already")])
    return values


KeyPath = Text
"""Keys and list indices joined by dots, as ``--set`` takes them."""


class Plot(Model):
    """Which curves are drawn."""

    x: KeyPath = Field(
        default="grid.cell",
        description="key of the case that errors are drawn against; of a list the largest entry",
    )
    group: Annotated[
        tuple[str, ...] | str | None,
        Either("a key or a list of keys", {str: KeyPath, tuple: tuple[KeyPath, ...], None: None}),
    ] = Field(
        default=None,
        description="keys of the case: runs with the same values make a curve; null: those that "
        "share what is swept besides x",
    )


class Study(Model):
    """A study: a case, what is changed in it, and how error and cost are measured."""

    format: Annotated[Count, AfterValidator(_format)] = Field(
        description="version of the study file's format", json_schema_extra={"enum": [1]}
    )
    title: Label = Field(default="", description="one line about the study")
    case: Text | None = Field(
        default=None, description="the case file, relative to the study file; may be swept instead"
    )
    set: Annotated[dict[str, Any], AfterValidator(_set)] = Field(
        default={}, description="changes for all runs: values by key path, as of --set"
    )
    bisect: Bisection | None = Field(
        default=None,
        description="the case is run with values of a key until it is known between which of them "
        "it comes to rest, and does not; once for each choice of the sweep, if there is one. null: "
        "runs as the sweep says",
    )
    sweep: Annotated[tuple[dict[str, Any], ...], AfterValidator(_sweep)] = Field(
        default=(),
        description="what is changed from run to run. An entry has lists of values by key path, "
        "taken together value by value; or changes by key path for each name. Every choice of one "
        "entry is combined with every choice of the others",
    )
    error: AnyMeasure | None = Field(
        default=None,
        description="not with `bisect`: what is taken for the error: a column of history.csv, its "
        "absolute value in the last line; or more exactly {column, at, reference, relative}",
    )
    cost: Annotated[tuple[Annotated[str, AfterValidator(_cost)], ...], AfterValidator(_unique)] = (
        Field(
            default=("wall", "particle-steps"),
            description="what the error is drawn against: wall, core (wall times ranks), "
            "particle-steps, steps",
        )
    )
    columns: tuple[AnyMeasure, ...] = Field(
        default=(), description="what else the tables show of each run, in the form of error"
    )
    ranks: Count = Field(default=1, description="ranks of every run")
    launcher: (
        Annotated[tuple[Label, ...], Field(min_length=1), AfterValidator(_launcher)] | None
    ) = Field(
        default=None,
        description="words that start a run, with {ranks} for their number; null: mpirun -n "
        "{ranks}, or nothing for one rank",
    )
    timeout: Positive | None = Field(
        default=None, description="a run that takes longer is stopped [s]"
    )
    folder: Text | None = Field(
        default=None,
        description="where runs, tables and plot go, relative to the study file; null: the "
        "study's name with .study.out, where pgimp is started",
    )
    plot: Plot = Field(default=Plot(), description="curves")

    @model_validator(mode="after")
    def _check_parts(self) -> Self:
        raise_problems("study", self._problems(), self)
        return self

    def _problems(self) -> Iterator[Problem]:
        if self.bisect is None:
            if not self.sweep:
                given = "sweep" in self.model_fields_set
                text = "expected at least 1 entry" if given else "missing (or bisect)"
                yield Problem(("sweep",), text, not given)
            if self.error is None:
                yield Problem(("error",), "missing (a column of history.csv)", True)
        for key in ("error", "columns") if self.bisect else ():
            if getattr(self, key):
                yield Problem((key,), "is none of a bisection, which gives a value: leave it out")
        swept = False
        seen: dict[str, str] = dict.fromkeys(self.set, "set")
        for number, entry in enumerate(self.sweep):
            named = is_named(entry)
            sets = entry.items() if named else [("", entry)]
            for name, changes in sets:
                for key in changes:
                    path: tuple[str | int, ...] = ("sweep", number, *([name] * named), key)
                    swept = swept or key == CASE
                    if over := next((o for o in seen if f"{o}.".startswith(f"{key}.")), None):
                        yield Problem(path, f"would undo {over} of {seen[over]}")
            for _, changes in sets:
                seen |= dict.fromkeys(changes, f"sweep.{number}")
        for number, quantity in enumerate(map(measure_of, self.columns)):
            if quantity.reference == LIMIT:
                yield Problem(("columns", number, "reference"), "only the error has a limit")
        if CASE in self.set:
            yield Problem(("set", CASE), "the case is named by the key 'case' of the study itself")
        if self.case is None and not swept:
            yield Problem((CASE,), "missing (the case file, relative to the study file)", True)

    @property
    def measure(self) -> Measure:
        """The measure of error."""
        assert self.error is not None
        return measure_of(self.error)

    @property
    def words(self) -> list[str]:
        """Words of the launcher, before the interpreter's name."""
        words = self.launcher
        if words is None:
            words = ("mpirun", "-n", "{ranks}") if self.ranks > 1 else ()
        return [word.replace("{ranks}", str(self.ranks)) for word in words]


def missing_file(value: object) -> str:
    """Message: the value is no name of a case file."""
    return f"expected the name of a case file, got {describe(value)}"
