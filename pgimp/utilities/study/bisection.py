"""Bisection of a study: between which values of a key a case comes to rest, and does not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from pgimp.running.log import Log
from pgimp.running.progress import duration
from pgimp.utilities.study.bisect_entry import Bisection
from pgimp.utilities.study.measures import number
from pgimp.utilities.study.plan import Bisected
from pgimp.utilities.study.runs import DONE, FAILED, Outcome, rests

#: States of a trial: it has come to rest, it has not, or it has, but slid before.
RESTS, MOVES, SLID = "at rest", "no rest", "slid"
_FOUND = RESTS, MOVES, SLID

#: Said where displacements are not looked at.
UNSEEN = (
    "displacements count in stages with `equilibrate` that the key changes, not before time 0: "
    "what slides there and rests as a heap is taken for at rest"
)


@dataclass
class Trial:
    """One run: the value of the key, and how it ended."""

    value: float
    outcome: Outcome

    @property
    def state(self) -> str:
        """`RESTS`, `MOVES`, or the state of a run that has failed otherwise."""
        if self.outcome.state != DONE:
            return self.outcome.state
        if self.outcome.slid is not None:
            return SLID
        return RESTS if self.outcome.value else MOVES

    @property
    def way(self) -> str:
        """The greatest displacement, and the limit that it is above; empty if it is not known."""
        if self.outcome.moved is None:
            return ""
        over = "" if self.outcome.slid is None else f", over {number(self.outcome.slid)}"
        return f"moved by {number(self.outcome.moved)}{over}"


@dataclass
class Bracket:
    """The bisection of one variant."""

    variant: Bisected
    trials: list[Trial] = field(default_factory=list)
    rests: float | None = None
    """The last value found at which it comes to rest."""
    moves: float | None = None
    """The last value found at which it does not."""
    message: str = ""

    @property
    def middle(self) -> float | None:
        """The result."""
        if self.rests is None or self.moves is None:
            return None
        return 0.5 * (self.rests + self.moves)

    @property
    def ended(self) -> bool:
        """Whether there is a result, as close as asked for."""
        return self.middle is not None and not self.message

    @property
    def width(self) -> float:
        """The width of the bracket."""
        return abs((self.moves or 0.0) - (self.rests or 0.0))

    def error(self, entry: Bisection) -> float | None:
        """Relative difference from the reference; None without one."""
        if entry.reference is None or self.middle is None:
            return None
        return abs(self.middle / entry.reference - 1.0)


def bisect(bracket: Bracket, entry: Bisection, run: Callable[[float], Outcome]) -> Iterator[Trial]:
    """Do the runs of a bisection in turn; each is yielded when it has ended.

    Parameters
    ----------
    bracket : Bracket
        The result, updated after every run.
    entry : Bisection
        Of the study.
    run : callable
        Runs the case with a value.
    """
    first, last = entry.between
    for value, expected in ((first, RESTS), (last, MOVES)):
        trial = _try(bracket, value, run)
        yield trial
        if trial.state not in _FOUND:
            return
        if (trial.state == RESTS) != (expected == RESTS):
            bracket.message = _misplaced(trial, entry)
            return
    while bracket.width > entry.tolerance:
        assert bracket.middle is not None
        middle = float(f"{bracket.middle:.12g}")  # in names of folders, too
        if middle in (bracket.rests, bracket.moves):  # neighbours among the numbers
            return
        trial = _try(bracket, middle, run)
        yield trial
        if trial.state not in _FOUND:
            return


def _misplaced(trial: Trial, entry: Bisection) -> str:
    """Say that the first trial is not at rest, or that the second is."""
    which = "second" if trial.state == RESTS else "first"
    text = f"with the {which} value, {entry.key} = {number(trial.value, 9)}, the case "
    if trial.state == SLID:
        return (
            f"{text}slides before it rests ({trial.way}): take another one, or a longer "
            "bisect.failure-displacement if it is soft, and only gives way"
        )
    how = "comes" if trial.state == RESTS else "does not come"
    return f"{text}{how} to rest: take another one"


def _try(bracket: Bracket, value: float, run: Callable[[float], Outcome]) -> Trial:
    trial = Trial(value, run(value))
    bracket.trials.append(trial)
    if trial.state == RESTS:
        bracket.rests = value
    elif trial.state in (MOVES, SLID):
        bracket.moves = value
    else:
        bracket.message = f"ended by the run of {number(value, 9)}: {trial.outcome.message}"
    return trial


def run_all(
    brackets: list[Bracket],
    entry: Bisection,
    folder: Path,
    again: bool,
    log: Log,
    check: Callable[[], None],
) -> None:
    """Do all bisections, and log every run and every result.

    Parameters
    ----------
    brackets : list of Bracket
        Their results.
    entry : Bisection
        Of the study.
    folder : Path
        The study's, with `runs` in it.
    again : bool
        Whether finished runs are run again.
    log : Log
        Receives messages.
    check : callable
        As of `pgimp.utilities.study.runs.perform`.
    """
    for bracket in brackets:
        variant = bracket.variant

        def run(value: float, variant: Bisected = variant) -> Outcome:
            planned = variant.planned(value)
            output = folder / "runs" / planned.name
            return rests(variant.study, planned, output, again, check)

        for trial in bisect(bracket, entry, run):
            one = trial.outcome
            text = f"{trial.state}: {one.message}" if one.state == FAILED else trial.state
            if "wall" in one.costs:
                text += f" after {one.info['steps']:,} steps in {duration(one.costs['wall'])}"
            text += f", {trial.way}" if trial.way else ""
            log.say(f"{one.plan.name}: {text}{' (from before)' if one.reused else ''}")
        log.say(result(bracket, entry))
    if any(bracket.variant.unseen for bracket in brackets):
        log.say(f"note: {UNSEEN}")


def result(bracket: Bracket, entry: Bisection) -> str:
    """Describe the result of a bisection in a line."""
    name = f"{bracket.variant.name}: " if bracket.variant.name else ""
    if bracket.middle is None:
        return f"{name}{bracket.message or 'not ended'}"
    text = (
        f"{name}{entry.key} is {number(bracket.middle, 6)}: at rest with "
        f"{number(bracket.rests, 9)}{_way(bracket, bracket.rests)}, not with "
        f"{number(bracket.moves, 9)}{_way(bracket, bracket.moves)}"
    )
    if (error := bracket.error(entry)) is not None:
        text += f"; {100.0 * error:.2g} % from {number(entry.reference, 6)}"
    return f"{text}; {bracket.message}" if bracket.message else text


def _way(bracket: Bracket, value: float | None) -> str:
    """Describe the displacement of the trial of a value, in parentheses."""
    found = [trial for trial in bracket.trials if trial.value == value and trial.way]
    return f" ({found[0].way})" if found else ""
