"""Checks of all stages before a run's first step: columns of the history, and steps."""

from collections.abc import Mapping, Sequence

import numpy as np

from pgimp.errors import CaseError
from pgimp.mpi.communicator import Communicator
from pgimp.scene.checks.sanity import small_step_warning
from pgimp.scene.checks.warned import Warned
from pgimp.scene.scene import Scene
from pgimp.scene.wave_speeds import rest_rate
from pgimp.solver.history.diagnostics import column_names
from pgimp.solver.particle_groups import fastest
from pgimp.solver.rank import Rank
from pgimp.solver.time.stability import require_stable, stability_warning, stable_courant

#: Columns of the history that are zero in stages without them; other columns are nan.
_SUMS = ("removed.", "added.", "outflow.", "stages.", "damped-")


def look_ahead(scenes: Sequence[Scene]) -> list[str]:
    """Return the columns of the history of a run of several stages, in their order.

    Stages are checked as far as possible without their particles.

    Parameters
    ----------
    scenes : sequence of Scene
        The scenes of all stages.

    Raises
    ------
    CaseError
        If a stage cannot be run.
    """
    columns: list[str] = []
    for scene in scenes:
        index = 0
        for name in column_names(scene):
            if name in columns:
                index = columns.index(name) + 1
            else:
                columns.insert(index, name)
                index += 1
    require_stable_stages(scenes, {})
    return columns


def absent(column: str) -> float:
    """Return a line's value in a column that its stage does not have."""
    return 0.0 if column.startswith(_SUMS) else float("nan")


def stage_rate(scene: Scene, rates: Mapping[str, float]) -> float:
    """Rate that limits the steps of a stage at rest, 1/time.

    Parameters
    ----------
    scene : Scene
        The stage's scene.
    rates : dict of str to float
        By name, the greatest rate of the particles of bodies with varying materials. These keep
        their parameters in all stages. The rates of other bodies are unknown.
    """
    found = [0.0]
    for body, name in enumerate(scene.body_names):
        found.append(
            rates.get(name, 0.0) if scene.materials.varies(body) else rest_rate(scene, body)
        )
    return max(found)


def rates_at_rest(rank: Rank, scene: Scene, comm: Communicator) -> dict[str, float]:
    """Return the rates for `stage_rate`, from the particles at the start; collective."""
    still = rank.up_to_date()._replace(v=np.zeros_like(rank.up_to_date().v))
    order, found = rank.population.order, {}
    for body, name in enumerate(scene.body_names):
        if scene.materials.varies(body):
            rows = order[still.body[order] == body]
            found[name] = max(comm.allgather(fastest(scene, still, rows, True)))
    return found


def require_stable_stages(scenes: Sequence[Scene], rates: Mapping[str, float]) -> list[Warned]:
    """Refuse fixed steps of later stages beyond the limit; warn of steps near it or far below.

    Parameters
    ----------
    scenes : sequence of Scene
        The scenes of all stages.
    rates : dict of str to float
        See `stage_rate`.

    Raises
    ------
    CaseError
        For the first one, with its key.
    """
    warnings = []
    for scene in scenes:
        case = scene.case
        step, number = case.time.step, case.staged.number
        if not number or case.watched or not isinstance(step, float | int):
            continue
        rate, stable = stage_rate(scene, rates), stable_courant(case)
        own = step != scenes[number - 1].case.time.step
        key = f"{case.staged.title}: time.{f'stages.{number - 1}.' if own else ''}step"
        try:
            require_stable(scene, float(step), rate)
        except CaseError as error:
            raise CaseError(str(error).replace("time.step", key, 1)) from None
        warnings += stability_warning(float(step), rate, stable, key)
        if own and rate > 0.0:
            warnings += small_step_warning(float(step), rate, key)
    return warnings
