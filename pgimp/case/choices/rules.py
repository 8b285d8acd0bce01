"""A rule by which a method is chosen. All of them are tables: of bodies and of scenes.

The page 'Which method' is made of them. Of the rules of a key the first that fits is taken.
`figure` has what supports it, measured where the page says.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from pgimp.case.choices.facts import BodyChoice


class Rule(NamedTuple):
    """A choice, when it is taken, and why."""

    key: str  #: Of the body, or of `method` and `time`.
    value: Any
    when: str  #: The condition in words.
    fits: Callable[[Any], bool]
    reason: str
    figure: str
    page: str  #: As links between pages have it.
    #: Of the scene's keys, which bodies need it: by a body, and whether it is in the initial
    #: configuration. The others have it because of these.
    whose: Callable[[BodyChoice, bool], bool] | None = None


def rule_of(rules: tuple[Rule, ...], key: str, of: object) -> Rule:
    """Return the first rule of a key that fits a body or a scene; one always does."""
    return next(rule for rule in rules if rule.key == key and rule.fits(of))
