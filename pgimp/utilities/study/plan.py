"""Reading and checking a study: every run with its case, before any run starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from pgimp.case.reader import read_document, validate
from pgimp.case.schema import Case
from pgimp.case.writer import dump_case
from pgimp.errors import CaseError, UsageError
from pgimp.schema.document import read
from pgimp.utilities.study import sliding
from pgimp.utilities.study.cases import Cases, Planned
from pgimp.utilities.study.schema import CASE, Study
from pgimp.utilities.study.sweep import Change, Variant, short, variants


@dataclass(frozen=True)
class Bisected:
    """A variant of the study whose runs differ in the bisected key."""

    name: str
    """Empty in a study without a sweep."""
    study: Study
    x: float
    """Abscissa of the table."""
    planned: Callable[[float], Planned]
    """Makes the run of a value."""
    unseen: bool = False
    """Whether the case may slide where that is not looked for, see `sliding.unwatched`."""


@dataclass(frozen=True)
class Plan:
    """A study with its runs, or with its bisections."""

    study: Study
    text: bytes
    name: str
    runs: tuple[Planned, ...]
    bisected: tuple[Bisected, ...] = ()


def read_plan(name: str | Path, examine: Callable[[Case], object] | None = None) -> Plan:
    """Read a study and check the cases of all its runs.

    Parameters
    ----------
    name : str or Path
        The study file.
    examine : callable, optional
        Raises a `CaseError` for a case with errors that only its particles show.

    Raises
    ------
    UsageError
        If the file cannot be read.
    CaseError
        For all errors in it or in its cases.
    """
    try:
        text = read(name)
    except OSError as error:
        raise UsageError(f"cannot read the study {name}: {error.strerror or error}") from None
    document = read_document(text, str(name))
    study = validate(Study, document, str(name))
    made = Cases(str(name), study, document)
    found = variants(study)
    if study.bisect:
        return _of_bisections(Plan(study, text, Path(name).stem, ()), made, found, examine)
    cases = [made.make(variant) for variant in found]
    made.raise_problems()
    complete = [(file, case) for file, case in cases if case is not None]
    made.check_measures(found, [case for _, case in complete])
    runs = made.arrange(found, complete)
    made.raise_problems()
    for one, (file, case) in zip(found, complete, strict=True):
        if examine is None:
            break
        try:
            examine(case)
        except CaseError as error:
            for line in str(error).splitlines():
                made.wrong[f"{file}: {line}"].append(one.name)
    made.raise_problems()
    return Plan(study, text, Path(name).stem, tuple(runs))


def _of_bisections(
    plan: Plan, made: Cases, found: list[Variant], examine: Callable[[Case], object] | None
) -> Plan:
    """The plan of a study that bisects, after the checks of both values of every variant.

    Raises
    ------
    CaseError
        For all errors in them.
    """
    study, swept, variants = plan.study, bool(plan.study.sweep), []
    entry = study.bisect
    assert entry is not None

    def of(one: Variant, value: float) -> Variant:
        parts = [one.name] * swept + [f"{entry.key.rpartition('.')[2]}-{value!r}"]
        change = Change(entry.key, value, ("bisect", "key"))
        return one._replace(name="_".join(parts), changes=(*one.changes, change))

    for one in found:

        def planned(value: float, one: Variant = one) -> Planned:
            run = of(one, value)
            file, case = made.make(run)
            made.raise_problems()
            assert case is not None
            options = tuple(item.option for item in run.changes if item.key != CASE)
            values = {item.key: short(item.value) for item in run.changes if item.path[0] != "set"}
            return Planned(run.name, file, options, values, dump_case(case), 0.0, one.name * swept)

        x, unseen = 0.0, False
        for value in entry.between:
            _, case = made.make(of(one, value))
            if case is None:
                continue
            if not any(stage.start.equilibrate for stage in case.stages):
                text = "has nothing that comes to rest: no stage with `equilibrate`, nor "
                "start.equilibrate"
                made.wrong[f"{made.label(('bisect',))}: the case {text}"].append(one.name)
            elif isinstance(entry.failure_displacement, float) and not sliding.watched(entry, case):
                text = "is for a stage with `equilibrate` that the key changes; the case has none"
                made.wrong[f"{made.label(('bisect', 'slide'))}: {text}"].append(one.name)
            unseen = entry.failure_displacement is not None and sliding.unwatched(entry, case)
            if examine is not None:
                try:
                    examine(case)
                except CaseError as error:
                    made.wrong[str(error)].append(one.name)
            x = made.number(study.plot.x, case.model_dump(by_alias=True), one)
        variants.append(Bisected(one.name if swept else "", study, x, planned, unseen))
    made.raise_problems()
    return replace(plan, bisected=tuple(variants))
