"""A pilot run: the case itself on a coarse grid, from which the number of steps is predicted.

Under Courant control a step follows the fastest wave, which speeds up in a body that is compressed
and with the particles' velocity. The number of steps is the integral of max_p(c_p + |v_p|) over
time, over the cell and the Courant number, but that steps lengthen rarely: the case's own are
counted by that rule. The integral hardly depends on the cells. Its
sensitivity follows from a further run on coarser cells: the error is assumed to grow linearly with
the cells. A run that is ended early gives no information on the time after it.
"""

from __future__ import annotations

from math import inf
from time import perf_counter
from typing import NamedTuple

from pgimp.case.schema import Case
from pgimp.errors import CaseError, RunError
from pgimp.geometry.regions import Points
from pgimp.mpi.comm import Serial
from pgimp.solver.configurations import fastest
from pgimp.solver.simulation import Simulation
from pgimp.solver.time.held_rate import LONGEST, HeldRate
from pgimp.utilities.model.costs import Costs

#: Seconds that a pilot run may take, about; it ends after twice as many.
_SECONDS = 2.0
#: Cells that remain across a body, unless it has fewer.
_FEWEST_CELLS = 6.0
#: Steps of a fixed length between two evaluations of the fastest wave.
_LOOK = 10
#: Further factors on the cells: with others a constraint may hold no particle.
_TRIES = (1.0, 0.9, 1.15, 0.8, 1.3, 0.65)
#: Repetitions on coarser cells of a run that took too long.
_REPEATS = 2
#: Factor on the cells of a further run, which shows their influence; and the least error for each
#: cell's length by which they are longer, as bodies tear later or earlier.
_COARSER, _LEAST_ERROR = 1.3, 0.05
#: Particles of a pilot run at most. Those of files do not become fewer with larger cells.
_MOST_PARTICLES = 200_000


class Pilot(NamedTuple):
    """Result of a pilot run.

    Attributes
    ----------
    steps : float
        Steps of the case itself, predicted.
    particles : int
        Of the pilot run.
    factor : float
        Its cells over those of the case.
    done : float
        Part of the time that it simulated. `steps` assumes that waves are as fast after it as at
        its end.
    failure : str
        First line of why it failed, if it did.
    courant : float
        Greatest Courant number of the case's own steps.
    error : float
        Estimate of the relative error of `steps` that is due to the cells; inf where there is none.
    """

    steps: float
    particles: int
    factor: float
    done: float
    failure: str
    courant: float
    error: float = 0.0


def pilot(case: Case, count: int, steps: float, costs: Costs, fewest: float) -> Pilot | None:
    """Run a case on a coarse grid, or as it is if that takes little time; nothing is written.

    Parameters
    ----------
    case : Case
        The case.
    count : int
        Its particles.
    steps : float
        Its steps, if the wave speed stays as it is.
    costs : Costs
        Of a step on this machine.
    fewest : float
        Cells across the thinnest body.

    Returns
    -------
    Pilot or None
        None where no pilot run can be made.
    """
    regions = [part for body in case.bodies.values() for part in body.region.simple()]
    fixed = sum(part.summary.number for part in regions if isinstance(part, Points))
    if fixed > _MOST_PARTICLES:
        return None
    most = max(1.0, fewest / _FEWEST_CELLS)
    factor = 1.0
    while factor < most and _seconds(case, count, steps, costs, factor) > _SECONDS:
        factor = min(1.1 * factor, most)
    # Rather too few cells across a body than too many particles.
    factor = max(factor, ((count - fixed) / _MOST_PARTICLES) ** (1.0 / case.dimensions))
    found = _first(case, factor)
    if found is None or found.failure:
        return found
    for _ in range(_REPEATS):  # waves became so much faster, or the machine slower
        if found.done < 1.0 and found.factor < most:
            longer = max(1.2, (1.5 / max(found.done, 0.01)) ** 0.7)
            again = _first(case, min(longer * found.factor, most))
            if again is not None and again.done > found.done:
                found = again
    if found.done < 1.0 or found.factor == 1.0 or case.time.steps is not None:
        return found
    return found._replace(error=_error(found, _first(case, _COARSER * found.factor)))


def _first(case: Case, factor: float) -> Pilot | None:
    """The first of `_TRIES` that can be made, run; None if there is none."""
    for tried in _TRIES if factor > 1.0 else (1.0,):
        try:
            sim = Simulation(coarse(case, max(1.0, factor * tried)), Serial())
        except (ValueError, CaseError, RunError):
            continue
        return _run(sim, case)
    return None


def _error(fine: Pilot, rough: Pilot | None) -> float:
    """Relative error of the steps of `fine`, growing linearly with the cells."""
    if rough is None or rough.done < 1.0 or not rough.factor > fine.factor:
        return inf
    slope = abs(fine.steps / rough.steps - 1.0) / (rough.factor - fine.factor)
    return max(slope, _LEAST_ERROR) * (fine.factor - 1.0)


def _seconds(case: Case, count: int, steps: float, costs: Costs, factor: float) -> float:
    """Time of a pilot run with cells `factor` times as long."""
    particles = count / factor**case.dimensions
    return steps / factor * (costs.fixed + particles * float(costs.particle(particles)))


def coarse(case: Case, factor: float) -> Case:
    """The same case with cells `factor` times as long, as far as the domain is whole cells.

    Raises
    ------
    ValueError, CaseError
        If that is no case.
    """
    grid, time = case.grid, case.time
    cells = [max(1, round(n / factor)) for n in grid.cells]
    data = case.model_dump(by_alias=True, exclude={"history", "checkpoint", "probes"})
    data["output"] = {"fields": case.output.fields, "at": case.output.at}
    data["grid"]["cell"] = [size / n for size, n in zip(grid.size, cells, strict=True)]
    if time.steps is not None:
        longer = min(n / m for n, m in zip(grid.cells, cells, strict=True))
        data["time"]["step"] = time.end / max(1, round(time.steps / longer))
    return Case.model_validate(data)


class _OwnSteps:
    """Steps that a case takes by itself where waves are as fast as in its pilot run."""

    def __init__(self, courant: float) -> None:
        self._courant, self._held = courant, HeldRate()
        self._left = self.count = 0.0

    def take(self, time: float, rate: float) -> None:
        """Take the steps of a time in which the largest (c_p + |v_p|)/L is `rate`."""
        self._left += time
        for _ in range(LONGEST):
            if self._left * max(self._held.rate, rate) < self._courant:
                return
            self._left -= self._courant / self._held.follow(rate)
            self.count += 1.0
        self.count, self._left = self.count + self._left * self._held.rate / self._courant, 0.0


def _run(sim: Simulation, case: Case) -> Pilot:
    begin, failure = perf_counter(), ""
    longer = max(1.0 / cell for cell in case.grid.cell) / max(sim.scene.frame.inverse)
    own = _OwnSteps(case.courant or inf)
    most = rate = 0.0
    try:
        while not sim.finished and perf_counter() - begin < 2.0 * _SECONDS:
            rate = _rate(sim) * longer
            sim.advance()
            own.take(sim.dt, max(rate, sim.fastest * longer))
            most = max(most, sim.dt * rate / longer)
    except RunError as error:
        failure = str(error).splitlines()[0]
    end = case.time.end
    own.take(end - sim.time, max(rate, sim.fastest * longer))
    steps = float(case.time.steps or 0) if case.courant is None else own.count
    done = sim.time / end
    return Pilot(steps, sim.count, longer, min(done, 1.0), failure, most)


def _rate(sim: Simulation) -> float:
    """Largest (c_p + |v_p|)/L; of fixed steps, which do not keep it, now and then."""
    if not sim.clock.controlled and sim.step % _LOOK == 0:
        sim.rate = fastest(sim.scene, sim.particles, sim.population.order, True)
    return sim.rate
