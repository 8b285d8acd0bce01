"""A pilot run: the case itself on a coarse grid, from which the number of steps is predicted.

Under Courant control a step follows the fastest wave, which is faster in compressed bodies and with
moving particles. The number of steps is the integral of max_p(c_p + |v_p|) over time, over the cell
and the Courant number. But steps lengthen rarely: the case's own steps are counted by that rule.
The integral hardly depends on the cells. Its sensitivity follows from a further run on coarser
cells; the error is assumed to grow linearly with the cells. A run that is ended early gives no
information on later times.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from time import perf_counter
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from pgimp.case.schema import Case
from pgimp.errors import CaseError, RunError
from pgimp.geometry.regions import Points
from pgimp.mpi.comm import Serial
from pgimp.solver.particle_groups import fastest
from pgimp.solver.simulation import Simulation
from pgimp.solver.time.held_rate import LONGEST, HeldRate
from pgimp.utilities.model.costs import Costs

#: Intended seconds of a pilot run; it is ended after twice as many.
_SECONDS = 2.0
#: Least cells across a body, unless the case has fewer.
_FEWEST_CELLS = 6.0
#: Steps of a fixed length between two evaluations of the fastest wave.
_LOOK = 10
#: Further factors on the cells, tried because a constraint may hold no particle.
_TRIES = (1.0, 0.9, 1.15, 0.8, 1.3, 0.65)
#: Repetitions on coarser cells if a run took too long.
_REPEATS = 2
#: Factor on the cells of a further run, which shows their influence. Least error per relative
#: increase of the cells, as bodies may tear earlier or later.
_COARSER, _LEAST_ERROR = 1.3, 0.05
#: Most particles of a pilot run. Particles from files do not become fewer with larger cells.
_MOST_PARTICLES = 200_000


class Pilot(NamedTuple):
    """Result of a pilot run."""

    steps: float  #: Predicted steps of the case itself.
    particles: int  #: Particles of the pilot run.
    factor: float  #: Its cells over the case's cells.
    #: Simulated fraction of the time. `steps` assumes that waves stay as fast as at its end.
    done: float
    failure: str  #: First line of the reason for a failure, if any.
    courant: float  #: Greatest Courant number of the case's own steps.
    #: Estimate of the relative error of `steps` due to the cells; inf without an estimate.
    error: float = 0.0
    #: Greatest principal strain at its end of each body, but for a hundredth of its particles.
    strains: Mapping[str, float] = MappingProxyType({})


def pilot(case: Case, count: int, steps: float, costs: Costs, fewest: float) -> Pilot | None:
    """Run a case on a coarse grid, or unchanged if it is short; nothing is written.

    It does not settle at the start.

    Parameters
    ----------
    count : int
        Number of its particles.
    steps : float
        Number of its steps, if the wave speed does not change.
    costs : Costs
        Costs of a step on this machine.
    fewest : float
        Cells across the thinnest body.

    Returns
    -------
    Pilot or None
        None if no pilot run is possible.
    """
    if case.start.equilibrate:  # its steps are not of the time
        start = case.start.model_copy(update={"equilibrate": None})
        case = case.model_copy(update={"start": start})
    regions = [part for body in case.bodies.values() for part in body.region.simple()]
    fixed = sum(part.summary.number for part in regions if isinstance(part, Points))
    if fixed > _MOST_PARTICLES:
        return None
    most = max(1.0, fewest / _FEWEST_CELLS)
    factor = 1.0
    while factor < most and _seconds(case, count, steps, costs, factor) > _SECONDS:
        factor = min(1.1 * factor, most)
    # Too few cells across a body are preferred to too many particles.
    factor = max(factor, ((count - fixed) / _MOST_PARTICLES) ** (1.0 / case.dimensions))
    found = _first(case, factor)
    if found is None or found.failure:
        return found
    for _ in range(_REPEATS):  # waves became faster, or the machine slower
        if found.done < 1.0 and found.factor < most:
            longer = max(1.2, (1.5 / max(found.done, 0.01)) ** 0.7)
            again = _first(case, min(longer * found.factor, most))
            if again is not None and again.done > found.done:
                found = again
    if found.done < 1.0 or found.factor == 1.0 or case.time.steps is not None:
        return found
    return found._replace(error=_error(found, _first(case, _COARSER * found.factor)))


def _first(case: Case, factor: float) -> Pilot | None:
    """Run the first possible of `_TRIES`; None if there is none."""
    for tried in _TRIES if factor > 1.0 else (1.0,):
        try:
            sim = Simulation(coarse(case, max(1.0, factor * tried)), Serial())
        except (ValueError, CaseError, RunError):
            continue
        return _run(sim, case)
    return None


def _error(fine: Pilot, rough: Pilot | None) -> float:
    """Relative error of the steps of `fine`, assumed linear in the cells."""
    if rough is None or rough.done < 1.0 or not rough.factor > fine.factor:
        return inf
    slope = abs(fine.steps / rough.steps - 1.0) / (rough.factor - fine.factor)
    return max(slope, _LEAST_ERROR) * (fine.factor - 1.0)


def _seconds(case: Case, count: int, steps: float, costs: Costs, factor: float) -> float:
    """Time of a pilot run with cells `factor` times as long."""
    particles = count / factor**case.dimensions
    return steps / factor * (costs.fixed + particles * float(costs.particle(particles)))


def coarse(case: Case, factor: float) -> Case:
    """The case with cells `factor` times as long, as far as the domain has whole cells.

    Raises
    ------
    ValueError, CaseError
        If the result is no valid case.
    """
    grid, time = case.grid, case.time
    cells = [max(1, round(n / factor)) for n in grid.cells]
    unused = {"history", "checkpoint", "probes", "gauges"}
    data = case.model_dump(by_alias=True, exclude=unused)
    data["output"] = {"fields": case.output.fields, "at": case.output.at}
    data["grid"]["cell"] = [size / n for size, n in zip(grid.size, cells, strict=True)]
    if time.steps is not None:
        longer = min(n / m for n, m in zip(grid.cells, cells, strict=True))
        data["time"]["step"] = time.end / max(1, round(time.steps / longer))
    return Case.model_validate(data)


class _OwnSteps:
    """Counter of the case's own steps, with the wave speeds of its pilot run."""

    def __init__(self, courant: float) -> None:
        self._courant, self._held = courant, HeldRate()
        self._left = self.count = 0.0

    def take(self, time: float, rate: float) -> None:
        """Count the steps of a time span with the largest (c_p + |v_p|)/L of `rate`."""
        self._left += time
        for _ in range(LONGEST):
            if self._left * max(self._held.rate, rate) < self._courant:
                return
            self._left -= self._courant / self._held.follow(rate)
            self.count += 1.0
        self.count, self._left = self.count + self._left * self._held.rate / self._courant, 0.0


def _run(sim: Simulation, case: Case) -> Pilot:
    begin, failure = perf_counter(), ""
    longer = max(1.0 / cell for cell in case.grid.cell) / max(sim.scene.domain.frame.inverse)
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
    strains = {} if failure else _strains(sim)
    return Pilot(steps, sim.count, longer, min(done, 1.0), failure, most, strains=strains)


def _strains(sim: Simulation) -> dict[str, float]:
    """Greatest principal strain of each body, but for a hundredth of its particles."""
    rows, D, found = sim.live(), sim.case.dimensions, {}
    F = sim.particles.F[rows, : D * D].reshape(-1, D, D)
    stretch = np.linalg.svd(F, compute_uv=False)
    strain = np.maximum(stretch[:, 0] - 1.0, 1.0 - stretch[:, -1])
    for number, name in enumerate(sim.case.body_names):
        own = strain[sim.particles.body[rows] == number]
        if len(own):
            found[name] = float(np.quantile(own, 0.99))
    return found


def _rate(sim: Simulation) -> float:
    """Largest (c_p + |v_p|)/L; with fixed steps, which do not store it, only occasionally."""
    if not sim.clock.controlled and sim.step % _LOOK == 0:
        sim.rate = fastest(sim.scene, sim.particles, sim.population.order, True)
    return sim.rate
