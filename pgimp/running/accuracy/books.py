"""Books of energy and momentum over a run, from the columns of its history."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pgimp.physics.functions.over_time import FunctionOfTime
from pgimp.schema.tables import VectorFunction

if TYPE_CHECKING:
    from pgimp.case.schema import Case

Array = np.ndarray

AXES = "xyz"

#: Columns of energies that material brought along, and took along.
_CAME, _LEFT = ("added", "inflow"), ("outflow", "removed")
#: Columns of what took energy, by pattern, and its name in the book. What is left is the method's.
_TAKEN = (
    ("plastic-work", "plastic flow"),
    ("viscous-work", "viscous stresses"),
    ("damped-energy", "damping"),
    (r"(contact|wall)\..*\.friction-heat", "friction"),
    (r"radiated\..*", "radiated through absorbing faces"),
    (r"(contact|wall)\..*\.impact-loss", "stopping what closes a gap"),
)
METHOD = "lost by the method"
#: Samples of a gravity that varies in time: fewest most per line of the history, and about all.
_SAMPLES, _MOST = 16, 1 << 14


class Entry(NamedTuple):
    """A line of a book: its name, and its value at each line of the history."""

    name: str
    values: Array


class EnergyBook(NamedTuple):
    """Where the energy of a run came from, and where it went."""

    #: given, stored, taken: Energy at the start and supplied since; present, or gone with material;
    #: dissipated. The last of `taken` closes the balance: what the method lost, artificial
    #: viscosity included.
    given: list[Entry]
    stored: list[Entry]
    taken: list[Entry]
    scale: float  #: The greatest energy that was present or given.
    #: Energy set in motion: kinetic at the start, and whenever it rose from line to line.
    moved: float
    #: Kinetic energy gained in the half step by which velocities are behind positions.
    behind: Array

    @property
    def lost(self) -> Array:
        """Energy lost by the method since the start, over `scale`; negative: gained."""
        return self.taken[-1].values / self.scale

    @property
    def gained(self) -> float:
        """Greatest energy from nothing, over `scale`: with velocities as they are, and in step."""
        lost = self.taken[-1].values
        return float(-np.nanmin(np.fmax(lost, lost - self.behind), initial=0.0)) / self.scale


def energy_book(history: Array) -> EnergyBook | None:
    """Return the book of energy; None without lines, columns, or any energy.

    Parameters
    ----------
    history : ndarray
        Lines of history.csv, a structured array.
    """
    names = history.dtype.names or ()
    if not len(history) or "dissipated-energy" not in names:
        return None
    kinetic, strain = history["kinetic-energy"], history["strain-energy"]
    first = float(kinetic[0] + strain[0])
    given = [
        Entry("at the start", np.full(len(history), first)),
        Entry("external work", np.array(history["external-work"])),
    ]
    given += [
        Entry(f"{name} material", _energy(history, name)) for name in _CAME if _has(names, name)
    ]
    if "stages.strain-energy" in names:
        given.append(Entry("stages' new materials", _known(history["stages.strain-energy"])))
    stored = [Entry("kinetic", np.array(kinetic)), Entry("strain", np.array(strain))]
    stored += [
        Entry(f"{name} material", _energy(history, name)) for name in _LEFT if _has(names, name)
    ]
    rest, taken = np.array(history["dissipated-energy"]), []
    for pattern, label in _TAKEN:
        columns = [name for name in names if re.fullmatch(pattern, name)]
        if columns:
            part = sum((_known(history[name]) for name in columns), np.zeros(len(history)))
            taken.append(Entry(label, part))
            rest = rest - part
    taken.append(Entry(METHOD, rest))
    supplied = sum((entry.values for entry in given), np.zeros(len(history)))
    present = sum((entry.values for entry in stored), np.zeros(len(history)))
    scale = float(np.nanmax(np.abs(np.concatenate([supplied, present]))))
    motion = _known(kinetic)
    moved = float(motion[0] + np.maximum(np.diff(motion), 0.0).sum())
    behind = np.zeros(len(history))
    if "dt" in names:
        behind = 0.5 * np.asarray(history["dt"]) * _slope(motion, np.asarray(history["time"]))
    return EnergyBook(given, stored, taken, scale, moved, behind) if scale > 0.0 else None


def _slope(values: Array, time: Array) -> Array:
    """Rate of change from line to line; 0 where it is not known."""
    if len(time) < 2:
        return np.zeros(len(time))
    with np.errstate(all="ignore"):
        return np.nan_to_num(np.gradient(values, time), nan=0.0, posinf=0.0, neginf=0.0)


def _has(names: tuple[str, ...], name: str) -> bool:
    return f"{name}.kinetic-energy" in names


def _energy(history: Array, name: str) -> Array:
    kinetic, strain = (history[f"{name}.{kind}-energy"] for kind in ("kinetic", "strain"))
    return _known(kinetic) + _known(strain)


def _known(values: Array) -> Array:
    """Values with zero where a stage does not have the column."""
    return np.nan_to_num(np.asarray(values, float), nan=0.0)


class MomentumBook(NamedTuple):
    """Momentum along one axis: impulses since the start, by name, and what they do not explain."""

    axis: str  #: x, y or z.
    change: float  #: Of the momentum, from the start to the last line.
    impulses: list[tuple[str, float]]  #: list of (str, float): On the material since the start.
    rest: float  #: Change less impulses.
    #: Sum of the impulses' sizes, and the greatest momentum sqrt(2 m K) of any motion with as much
    #: kinetic energy.
    scale: float


def edited_functions(starts: Sequence[Mapping[str, Any]]) -> set[str]:
    """Return the functions of one's own that have changed from one start of a run to another.

    Parameters
    ----------
    starts : sequence of mapping
        Those of run.json.
    """
    known = [start.get("functions") or {} for start in starts]
    names = {name for one in known for name in one}
    return {name for name in names if len({one.get(name) for one in known}) > 1}


def _functions(gravity: Any) -> set[str]:
    """Names of the functions of one's own in a gravity, as run.json has them."""
    components = getattr(gravity, "components", ())
    own = [one.registered for one in components if isinstance(one, FunctionOfTime)]
    return {
        f"{one.function.__module__}.{one.function.__qualname__}.{one.kind.name}_values"
        for one in own
    }


def momentum_books(
    case: Case, history: Array, edited: Collection[str] = ()
) -> tuple[list[MomentumBook], str]:
    """Return the books of momentum, an axis each, or the reason why there are none.

    Parameters
    ----------
    history : ndarray
        Lines of history.csv.
    edited : collection of str
        See `edited_functions`.
    """
    stages = case.stages
    names = history.dtype.names or ()
    if len(history) < 2 or "momentum-x" not in names:
        return [], "the history has fewer than two lines"
    unknown = [
        *("tractions" for one in stages if one.tractions),
        *("a body force" for one in stages if one.body_force is not None),
        *("water in the ground" for one in stages if one.water is not None),
        *("steps that settle" for one in stages if one.start.equilibrate),
        *("axisymmetric rings" for one in stages if one.axisymmetric),
        *(
            "gravity, whose function has changed since the run began"
            for one in stages
            if not _functions(one.gravity).isdisjoint(edited)
        ),
    ]
    if unknown:
        named = " and ".join(dict.fromkeys(unknown))
        return [], f"the history does not have the impulse of {named}"
    return [_book(case, history, axis) for axis in range(case.dimensions)], ""


def _book(case: Case, history: Array, axis: int) -> MomentumBook:
    momentum = np.asarray(history[f"momentum-{AXES[axis]}"], float)
    impulses = [*_impulses(case, history, axis)]
    change = float(momentum[-1] - momentum[0])
    motion = np.sqrt(2.0 * _known(history["mass"]) * _known(history["kinetic-energy"]))
    scale = sum(abs(value) for _, value in impulses) + float(motion.max())
    rest = change - sum(value for _, value in impulses)
    return MomentumBook(AXES[axis], change, impulses, rest, scale)


def _impulses(case: Case, history: Array, axis: int) -> Iterator[tuple[str, float]]:
    """Impulses on the material along an axis until the last line, by name."""
    names, times, end = history.dtype.names or (), np.asarray(history["time"]), f"-{AXES[axis]}"
    spans = np.diff(times)
    for name in names:
        force = re.fullmatch(r"((reaction|constraint)\.(.*)|rigid\.(.*)\.force)" + end, name)
        if force:
            sign = -1.0 if name.startswith("rigid.") else 1.0
            label = f"rigid body '{force[4]}'" if force[4] else f"{force[2]} {force[3]}"
            yield label, sign * float(_known(history[name])[1:] @ spans)
    if (weight := _weight(case, history, axis)) is not None:
        yield "gravity", weight
    for label, sign in (("inflow", 1.0), ("added", 1.0), ("outflow", -1.0), ("removed", -1.0)):
        if f"{label}.momentum{end}" in names:
            values = _known(history[f"{label}.momentum{end}"])
            yield f"{label} material", sign * float(values[-1] - values[0])
    if f"damped-momentum{end}" in names:
        values = _known(history[f"damped-momentum{end}"])
        yield "damping", -float(values[-1] - values[0])


def _weight(case: Case, history: Array, axis: int) -> float | None:
    """Impulse of gravity along an axis, as the steps take it; None without gravity."""
    times, mass = np.asarray(history["time"]), _known(history["mass"])
    total, found = 0.0, False
    for stage in case.stages:
        low, high = stage.staged.start, stage.time.end
        if stage.gravity is None or not high > low:
            continue
        found = True
        begin, end = np.maximum(times[:-1], low), np.minimum(times[1:], high)
        within = np.flatnonzero(end > begin)
        most = max(_SAMPLES, _MOST // max(len(within), 1))
        for k in within.tolist():
            whole = int(history["step"][k + 1] - history["step"][k])
            part = (end[k] - begin[k]) / (times[k + 1] - times[k])
            steps = max(round(whole * part), 1)
            impulse = _impulse(stage.gravity, axis, (begin[k], end[k]), (times, mass), steps, most)
            total += impulse / stage.time.mass_scaling  # whose masses are in the history
    return total if found else None


def _impulse(
    gravity: Any, axis: int, ends: tuple[float, float], known: tuple[Array, Array],
    steps: int, most: int,
) -> float:  # fmt: skip
    """Impulse of gravity between two times, by so many steps; `known` has times and masses."""
    if not isinstance(gravity, VectorFunction):
        return float(gravity[axis]) * float(np.trapezoid(np.interp(ends, *known), ends))
    at = np.linspace(*ends, min(steps, most) + 1)
    force = np.array([gravity.value(float(t))[axis] for t in at]) * np.interp(at, *known)
    # A step takes the force at its beginning, so that the sum of the steps lags behind by a half.
    late = 0.5 * (force[-1] - force[0]) * (ends[1] - ends[0]) / steps
    return float(np.trapezoid(force, at) - late)
