"""The program of a step: what it does in this scene, in the order of the algorithm, as observed.

Steps of a small scene like the case are watched: kernels called from Python, parts of the step, and
the contact's methods. So the list is what is run. Whatever is optional in the arguments of a kernel
is compiled into it only where a scene has it; its name and meaning are those of the argument.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from inspect import getdoc, getsource, isfunction
from itertools import chain
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from pgimp.case.schema import Case
from pgimp.errors import CaseError, RunError
from pgimp.jit.observed import observed
from pgimp.kernels.data.arguments import Field, KernelScene, Order
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.comm import Serial
from pgimp.solver.contact.base import NoContact
from pgimp.solver.parts import PARTS
from pgimp.solver.rank import PHASES
from pgimp.solver.simulation import Simulation
from pgimp.solver.vertices import StepPart
from pgimp.utilities.model.sample_cases import resized

#: Particles up to which the case itself is watched; of a larger one a smaller sample.
_MAX_PARTICLES = 20_000
#: Steps that are watched, and those of a block: some parts act in every eighth.
_STEPS, _BLOCK = 72, 8
#: What is done from the end of a step to the beginning of the next one.
_BETWEEN = "between steps", "maxima of all ranks, guard of the energy, rows sorted anew, windows"
#: Further factors on the cells of a sample, for cases that a coarse grid does not fit.
_POWERS = (1.0, 0.9, 0.8, 0.7)

#: A field of a record, with the lines of `#:` above it, or what stands beside it.
_FIELD = re.compile(r"((?:^ +#: .*\n)*)^ +(\w+): [^#\n]*?(?:  #: (.*))?$", re.M)

Key = tuple[int, str, str]


@dataclass
class Row:
    """What a step does: a phase, a kernel, or a method of a part of the step."""

    meaning: str  #: What it is for.
    per: str = ""  #: {"particle", "vertex", ""}: What its time goes with.
    #: What is compiled into it for this scene, with the meaning.
    features: dict[str, str] = field(default_factory=dict)
    #: Time in each block of watched steps.
    seconds: list[float] = field(default_factory=lambda: [0.0] * (_STEPS // _BLOCK))
    steps: int = 0  #: Number of the watched steps that have it; `last` is the last one.
    last: int = -1

    def add(self, step: int, seconds: float) -> None:
        """Add to the time in a step, by its number among those that are watched."""
        self.seconds[step // _BLOCK] += seconds
        self.steps, self.last = self.steps + (step != self.last), step

    def step(self, steps: int) -> float:
        """Seconds a step, of so many: the median of blocks, as other programs disturb some."""
        if steps < _STEPS:
            return sum(self.seconds) / steps
        return median(self.seconds) / _BLOCK


class Watch:
    """The steps of a simulation, as they are done.

    Parameters
    ----------
    sim : Simulation
        The simulation; it is not to be used by others.

    Attributes
    ----------
    steps : int
        Steps that were watched.
    rows : dict of (int, str, str) to Row
        By number of the phase in a step, part, and name; a phase has "" for both.
    phases : dict of int to str
        Names of the phases by their numbers.
    """

    def __init__(self, sim: Simulation) -> None:
        self._sim, self._part, self._phase, self._noting = sim, "", 0, 0.0
        self._begin = 0.0
        self._order: list[Key] = []
        self._last = -1
        self.steps = 0
        self.rows: dict[Key, Row] = {}
        self.phases: dict[int, str] = {}

    def run(self) -> None:
        """Do the steps, fewer if the case has fewer."""
        sim, rank = self._sim, self._sim.rank
        stopwatch = rank.stopwatch
        rank.stopwatch = lambda: self._laps(stopwatch())  # type: ignore[method-assign]
        for name in PARTS:
            if part := getattr(rank, name):
                self._hook(part, StepPart, name)
        self._hook(rank.contact, NoContact, "contact")
        if sim.watch:
            sim.watch.look = self._noted(sim.watch.look, "watch.look", first_line(sim.watch.look))  # type: ignore[method-assign]
        with observed(self._note):
            while self.steps < _STEPS and not sim.stage_done:
                sim.advance()
                self._end_phase(*_BETWEEN)
                self.steps += 1

    def ordered(self) -> list[tuple[Key, Row]]:
        """The rows in the order of the algorithm, each phase before what it has."""
        keys = sorted(self._order, key=lambda key: (key[0], key[1:] != ("", "")))
        return [(key, self.rows[key]) for key in keys if key[0] in self.phases]

    def _now(self) -> float:
        """Time without that of noting."""
        return perf_counter() - self._noting

    def _laps(self, lap: Callable[[str], None]) -> Callable[[str], None]:
        """Begin a step: its phases have numbers, in the order in which they end."""
        self._phase, self._last = 0, -1
        self._begin = self._now()

        def next_lap(phase: str) -> None:
            lap(phase)
            self._end_phase(phase, PHASES[phase])

        return next_lap

    def _end_phase(self, phase: str, meaning: str) -> None:
        """Add the time since the last phase to the next one."""
        now = self._now()
        self.phases[self._phase] = phase
        self._row((self._phase, "", ""), meaning).add(self.steps, now - self._begin)
        self._phase, self._begin = self._phase + 1, self._now()

    def _row(self, key: Key, meaning: str) -> Row:
        """The row of a key; a new one comes after the one before it in this step."""
        if key not in self.rows:
            self.rows[key] = Row(meaning)
            self._order.insert(self._last + 1, key)
        self._last = self._order.index(key)
        return self.rows[key]

    def _note(self, kernel: Callable, args: tuple[object, ...], seconds: float) -> None:
        begin = perf_counter()
        key = (self._phase, self._part, getattr(kernel, "__name__", str(kernel)))
        row = self._row(key, first_line(kernel))
        row.add(self.steps, seconds)
        if not row.features:
            kinds = {type(each) for each in args}
            row.per = "particle" if kinds & {Particles, Order} else "vertex" * (Field in kinds)
            row.features = {"": ""} | dict(chain(*(features_of(arg, self._sim) for arg in args)))
        self._noting += perf_counter() - begin

    def _hook(self, owner: Any, base: type, name: str) -> None:
        """Have the methods of a step that a class overrides noted, with what they call."""
        for method, plain in vars(base).items():
            own = getattr(type(owner), method, None)
            if method.startswith("_") or not isfunction(plain) or own is plain:
                continue
            meaning = first_line(own)
            if not meaning or meaning.startswith("See "):  # all parts have the same methods
                meaning = first_line(type(owner) if base is StepPart else plain)
            setattr(owner, method, self._noted(getattr(owner, method), f"{name}.{method}", meaning))

    def _noted(self, call: Callable, name: str, meaning: str) -> Callable:
        """A method that is noted, with what it calls as its parts."""

        def noted(*args: Any) -> Any:
            row, outer = self._row((self._phase, self._part, name), meaning), self._part
            self._part, begin = name, self._now()
            try:
                return call(*args)
            finally:
                row.add(self.steps, self._now() - begin)
                self._part = outer

        return noted


def first_line(thing: Any) -> str:
    """First sentence of a docstring, as far as its first line has it."""
    line = (getdoc(getattr(thing, "py_func", thing)) or "").split("\n")[0].split(". ")[0]
    return line.rstrip(".").replace("; collective", "")


def features_of(arg: Any, sim: Simulation) -> Iterator[tuple[str, str]]:
    """What of an argument of a kernel a scene need not have, and has: names and meanings."""
    if not (isinstance(arg, tuple) and hasattr(arg, "_fields")):
        return
    if isinstance(arg, KernelScene):
        yield from _of_setting(arg, sim)
        return
    meanings, defaults = meanings_of(type(arg)), getattr(arg, "_field_defaults", {})
    for name, value in zip(arg._fields, arg, strict=True):
        optional = defaults.get(name, 0) == ()
        if optional and not (isinstance(value, tuple) and len(value) == 0):
            yield name, meanings.get(name, "")
        elif not optional:
            yield from features_of(value, sim)


def _of_setting(setting: KernelScene, sim: Simulation) -> Iterator[tuple[str, str]]:
    """Shape, geometry, and laws if the kernel has them."""
    if setting.shape != ():
        yield f"shape {sim.case.method.shape}", first_line(type(sim.case.method))
    yield f"{len(setting.frame.cell)}D", first_line(type(setting.frame))
    table = sim.scene.materials
    if setting.materials:
        for name, entry in zip(table.names, table.entries, strict=True):
            yield f"law {getattr(entry, 'model', name)}", first_line(type(entry))


def meanings_of(record: type) -> dict[str, str]:
    """The first sentences of what stands beside the fields of a record, or above them."""
    found: dict[str, str] = {}
    for above, name, beside in _FIELD.findall(getsource(record)):
        text = beside or " ".join(line.strip()[3:] for line in above.splitlines())
        names, several, rest = text.partition(": ")
        if several and all(each in record.__annotations__ for each in names.split(", ")):
            found |= dict.fromkeys(names.split(", "), _sentence(rest))
        elif text:
            found[name] = _sentence(text)
    return found


def _sentence(text: str) -> str:
    """First sentence of what stands beside a field, without its kind."""
    return re.sub(r"^.*? or \(\): ", "", text).split(". ")[0].rstrip(".")


def watched(case: Case, count: int, settling: bool = False) -> tuple[Watch, Simulation] | str:
    """Watch steps of a case, or of a smaller one like it; the reason if that cannot be.

    They are those of the time, or, while the start is `settling`, those before it.
    """
    if case.start.equilibrate and not settling:
        start = case.start.model_copy(update={"equilibrate": None})
        case = case.model_copy(update={"start": start})
    factor, reason = max(1.0, (count / _MAX_PARTICLES) ** (1.0 / case.dimensions)), ""
    for power in _POWERS if factor > 1.0 else (0.0,):
        try:
            sim = Simulation(resized(case, factor**power) if power else case, Serial())
            watch = Watch(sim)
            watch.run()
        except (ValueError, CaseError, RunError) as error:
            reason = str(error).splitlines()[0]
            continue
        return watch, sim
    return reason


def report_program(case: Case, count: int) -> None:
    """Print what a step does, in its order, with the time that each part of it takes."""
    found = watched(case, count)
    if isinstance(found, str):
        print(f"a step           its parts are unknown, no sample can be run: {found}")
        return
    watch, sim = found
    planes, size = int(sim.rank.grid.active.sum()), sim.rank.grid.window.extent[1:]
    numbers = {"particle": sim.rank.count, "vertex": planes * int(np.prod(size))}
    which = "" if count <= _MAX_PARTICLES else " of a sample"
    print(
        f"a step           in its order; median of {watch.steps} steps{which} with "
        f"{sim.rank.count:,} particles, {numbers['vertex']:,} vertices of planes in use"
    )
    print(
        "                 phases are those of the log, with their sums; one comes again where the "
        "step comes back to it"
    )
    features: dict[str, str] = {}
    for (phase, part, name), row in watch.ordered():
        time = _time(row, watch.steps, numbers.get(row.per, 0))
        indent = " " * (2 + 2 * bool(name) + 2 * bool(part))
        print(f"{indent + (name or watch.phases[phase]):<34} {time:<20} {row.meaning}")
        features |= row.features
    if case.start.equilibrate:
        _report_settling(case, count, watch)
    print("  what of it is compiled in for this scene:")
    for name, meaning in features.items():
        if meaning:
            print(f"    {name:<29} {meaning}")


def _time(row: Row, steps: int, number: int = 0) -> str:
    """Time in a step, for each of some particles or vertices; or how many of the steps have it."""
    if not (seconds := row.step(steps)):
        return f"{row.steps} of {steps} steps"
    return f"{1e9 * seconds / number:.3g} ns a {row.per}" if number else f"{1e6 * seconds:.3g} us"


def _report_settling(case: Case, count: int, watch: Watch) -> None:
    """Print what a step to rest has that one of the time has not, and the other way round."""
    if isinstance(found := watched(case, count, True), str):
        print(f"a step to rest   its parts are unknown, no sample can be run: {found}")
        return
    own = {key[2]: row for key, row in found[0].ordered() if key[2]}
    plain = {key[2] for key, _ in watch.ordered()}
    missing = ", ".join(sorted(plain - {"", *own})) or "nothing"
    print(f"a step to rest   without {missing}; and with")
    for name, row in own.items():
        if name not in plain:
            print(f"    {name:<30} {_time(row, found[0].steps):<20} {row.meaning}")
