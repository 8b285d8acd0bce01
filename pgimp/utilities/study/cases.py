"""The cases of a study's runs, with all their errors."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pgimp.case.reader import read_document, validate
from pgimp.case.schema import Case
from pgimp.case.writer import dump_case
from pgimp.errors import CaseError
from pgimp.scene.scene import Scene
from pgimp.schema.document import MOST_MESSAGES, Document, read
from pgimp.schema.messages import dotted, unknown
from pgimp.schema.overrides import change
from pgimp.schema.words.renamed import new_path
from pgimp.solver.history.diagnostics import column_names
from pgimp.utilities.study.measure_entry import Measure, measure_of
from pgimp.utilities.study.measures import SAME_TIME
from pgimp.utilities.study.schema import CASE, Study, missing_file
from pgimp.utilities.study.sweep import Variant, short

_ABSENT = object()


@dataclass(frozen=True)
class Planned:
    """A planned run."""

    name: str
    file: str
    """The path of the case's file that a run is given."""
    options: tuple[str, ...]
    """The changes, as ``--set`` takes them."""
    values: Mapping[str, str]
    """The swept values, by key, as short texts."""
    resolved: str
    """The text of case.yaml that a finished run of it has."""
    x: float
    """Abscissa of the errors."""
    curve: str
    """Name of the curve that it belongs to."""


class Cases:
    """Makes the cases of a study, and collects their errors."""

    def __init__(self, name: str, study: Study, document: Document) -> None:
        self.name = name
        self.study = study
        self.document = document
        self.documents: dict[str, Document | OSError | CaseError] = {}
        self.wrong: dict[str, list[str]] = defaultdict(list)

    def raise_problems(self) -> None:
        """Raise the errors, each message once, with its runs."""
        lines = [
            f"{text} (run {runs[0]}{f' and {len(runs) - 1} more' if len(runs) > 1 else ''})"
            for text, runs in self.wrong.items()
        ]
        if len(lines) > MOST_MESSAGES:
            lines[MOST_MESSAGES:] = [f"{self.name}: and {len(lines) - MOST_MESSAGES} more"]
        if lines:
            raise CaseError("\n".join(lines))

    def label(self, path: tuple[str | int, ...]) -> str:
        """Return file, line and key of a part of the study."""
        location = self.document.location(path)
        where = f"{self.name}:{location}" if location else self.name
        return f"{where}: {dotted(self.document.as_written(path))}"

    def read(self, path: str) -> Document:
        """Return a changeable copy of a case file's content; many runs may share the file."""
        if path not in self.documents:
            try:
                self.documents[path] = read_document(read(path), path)
            except (OSError, CaseError) as error:
                self.documents[path] = error
        found = self.documents[path]
        if isinstance(found, Document):
            return deepcopy(found)
        raise found

    def make(self, variant: Variant) -> tuple[str, Case | None]:
        """Return the file and the case of a run, None if the case is wrong."""
        file: Any = self.study.case
        label = self.label((CASE,))
        for one in variant.changes:
            if one.key == CASE:
                file, label = one.value, self.label(one.path)
        if not isinstance(file, str):
            self.wrong[f"{label}: {missing_file(file)}"].append(variant.name)
            return "", None
        path = os.path.relpath(Path(self.name).parent / file)
        try:
            document = self.read(path)
            for one in variant.changes:
                if one.key != CASE:
                    change(document, one.key.split("."), deepcopy(one.value), self.label(one.path))
            return path, validate(Case, document, path)
        except OSError as error:
            text = f"{label}: cannot read the case {path}: {error.strerror or error}"
            self.wrong[text].append(variant.name)
        except CaseError as error:
            for line in str(error).splitlines():
                self.wrong[line].append(variant.name)
        return path, None

    def check_measures(self, found: list[Variant], cases: list[Case]) -> None:
        """Check that histories will have the measured quantities.

        Every run needs the error. A further column, which runs may lack, is wrong if no run has
        it.
        """
        names: list[list[str]] = []
        for one, case in zip(found, cases, strict=True):
            try:
                names.append(column_names(Scene(case)))
            except CaseError as error:
                names.append([])
                self.wrong[f"{self.name}: {error}"].append(one.name)
        quantity = self.study.measure
        assert self.study.error is not None
        path = ("error",)
        for one, case, known in zip(found, cases, names, strict=True):
            if known:
                self._check_measure(path, self.study.error, quantity, known, case, one)
        everywhere = list(dict.fromkeys(name for known in names for name in known))
        last = max(cases, key=lambda case: case.time.last)
        for i, entry in enumerate(self.study.columns):
            self._check_measure(
                ("columns", i), entry, measure_of(entry), everywhere, last, found[0]
            )

    def _check_measure(
        self,
        path: tuple[str | int, ...],
        entry: str | Measure,
        quantity: Measure,
        known: list[str],
        case: Case,
        variant: Variant,
    ) -> None:
        inside = not isinstance(entry, str)
        if quantity.column not in known:
            text = unknown("column", quantity.column, known, "history.csv will have")
            label = self.label((*path, "column") if inside else path)
            self.wrong[f"{label}: {text}"].append(variant.name)
        end = case.time.last
        if quantity.last > end * (1.0 + SAME_TIME):
            text = f"{quantity.last:.15g} is after the end at {end:.15g} (time.end)"
            self.wrong[f"{self.label((*path, 'at'))}: {text}"].append(variant.name)

    def arrange(self, found: list[Variant], cases: list[tuple[str, Case]]) -> list[Planned]:
        """Find abscissa and curve of every run."""
        plot = self.study.plot
        data = [case.model_dump(by_alias=True) for _, case in cases]
        x = [self.number(plot.x, content, one) for content, one in zip(data, found, strict=True)]
        keys = (plot.group,) if isinstance(plot.group, str) else plot.group
        if keys is None:
            moving = _moving(found, x)
            curves = [
                ", ".join(label for i, label in enumerate(one.labels) if i not in moving)
                for one in found
            ]
        else:
            curves = [
                ", ".join(self._text(key, content, one, ("plot", "group")) for key in keys)
                for content, one in zip(data, found, strict=True)
            ]
        return [
            Planned(
                one.name,
                file,
                tuple(item.option for item in one.changes if item.key != CASE),
                {item.key: short(item.value) for item in one.changes if item.path[0] != "set"},
                dump_case(case),
                x[i],
                curves[i],
            )
            for i, (one, (file, case)) in enumerate(zip(found, cases, strict=True))
        ]

    def number(self, key: str, data: dict[str, object], variant: Variant) -> float:
        """Return the greatest number at a key path of a case, or list what is wrong with it."""
        value = self._value(key, data, variant, ("plot", "x"))
        entries = value if isinstance(value, list | tuple) and value else [value]
        if all(isinstance(entry, int | float) and not isinstance(entry, bool) for entry in entries):
            return float(max(entries))
        if value is not _ABSENT:
            text = f"{self.label(('plot', 'x'))}: {key} is {short(value)}, not a number"
            self.wrong[text].append(variant.name)
        return 0.0

    def _text(
        self, key: str, data: dict[str, object], variant: Variant, path: tuple[str, ...]
    ) -> str:
        value = self._value(key, data, variant, path)
        if value is _ABSENT:
            return ""
        return value if isinstance(value, str) else f"{key.rpartition('.')[2]} {short(value)}"

    def _value(self, key: str, data: Any, variant: Variant, path: tuple[str, ...]) -> object:
        """Return the resolved case's value at a key path."""
        for part in new_path(key.split(".")):
            try:
                data = data[int(part) if isinstance(data, list | tuple) else part]
            except (KeyError, IndexError, ValueError, TypeError):
                swept = dict.fromkeys(one.key for one in variant.changes if one.path[0] != "set")
                text = f"{self.label(path)}: the case has no {key}; swept are {', '.join(swept)}"
                self.wrong[text].append(variant.name)
                return _ABSENT
        return data


def _moving(found: list[Variant], x: list[float]) -> set[int]:
    """Return the entries of the sweep whose choices change x, with all others equal."""
    moving = set()
    for entry in range(len(found[0].choices)):
        first: dict[tuple[int, ...], float] = {}
        for one, value in zip(found, x, strict=True):
            others = one.choices[:entry] + one.choices[entry + 1 :]
            if first.setdefault(others, value) != value:
                moving.add(entry)
    return moving
