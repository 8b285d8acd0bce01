"""All features that exclude each other: checks and the reference's table are made of this one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

from pgimp.case.checks.exclusions.runs import RUNS
from pgimp.case.checks.exclusions.scenes import SCENES
from pgimp.schema.problems import Problem

EXCLUSIONS = SCENES + RUNS

FEATURES = tuple(dict.fromkeys(feature for each in EXCLUSIONS for feature in (each.a, each.b)))
"""All features of the table."""


def check_exclusions(parts: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problems of features that exclude each other, of the `parts` that are sound."""
    found = {feature: feature.places(parts) for feature in FEATURES}
    told = (each.problems(found[each.a], found[each.b]) for each in EXCLUSIONS)
    yield from dict.fromkeys(chain.from_iterable(told))
