"""The stability limit of a step: Courant = dt max_p((c_p + |v_p|)/L)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.body import any_means, scene_method
from pgimp.case.stepping.courant import averaged_limit, vertex_limit
from pgimp.errors import CaseError
from pgimp.physics.materials.base import has
from pgimp.scene.checks.warned import Warned, warned
from pgimp.solver.time.limiting import limiting

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.scene.scene import Scene

#: More controlled steps than this before the next stop mean that a run would never end.
MOST_STEPS = 1e12

#: A wave speed that has grown by this factor, with this number of steps left, is not physical. A
#: run whose controlled step collapses would go on for weeks.
BLOWN_UP, BLOWN_UP_STEPS = 1e5, 1e5

_MOST_ENERGY = 1e280

#: Courant number above which a step is refused. Warnings begin above `Shape.stable`.
REFUSED = 1.0


#: Stability limits with mean dilatation, by dimensions and Poisson's ratio: Courant number, and its
#: product with particles a cell (docs/hard-cases.md). For ratios above, `Shape.stable` is the
#: limit.
_MEAN = {
    2: {0.3: (0.45, 0.9), 0.4: (0.45, 0.84), 0.45: (0.45, 0.8)},
    3: {0.3: (0.45, 0.65), 0.4: (0.4, 0.59), 0.45: (0.37, 0.53)},
}


def stable_courant(case: Case) -> float:
    """Courant number up to which free surfaces stay stable; above, there is a warning.

    The shape's limit, raised with mean dilatation if no body is nearly incompressible. If all
    bodies are in the initial configuration it is theirs.
    """
    method, vertices = scene_method(case), vertex_limit(case)
    if vertices is not None:
        return vertices
    least = averaged_limit(case, float(method.stable))
    if not any_means(case):
        return least
    used = (case.materials[body.material] for body in case.bodies.values())
    ratios = [getattr(material, "poisson", 0.5) for material in used]
    most = max(float(nu) if isinstance(nu, float | int) else 0.5 for nu in ratios)
    measured, limits = zip(*_MEAN[case.dimensions].items(), strict=True)
    if most > measured[-1]:
        return least
    limit, of_one = (float(np.interp(most, measured, each)) for each in zip(*limits, strict=True))
    return max(least, averaged_limit(case, min(limit, of_one / max(method.particles_per_cell))))


def check_first_step(scene: Scene, dt: float, rate: float) -> list[Warned]:
    """Compare the first step of a simulation with the stability limit.

    Parameters
    ----------
    rate : float
        Largest (c_p + |v_p|)/L, 1/time.

    Returns
    -------
    list of Warned
        Warnings.

    Raises
    ------
    CaseError
        As from `require_stable`.
    """
    stable = stable_courant(scene.case)
    require_stable(scene, dt, rate)
    if scene.case.watched:
        return []
    return stability_warning(dt, rate, stable)


def require_end(scene: Scene, rate: float) -> None:
    """Refuse a run that would never end, or has energies that no float64 can hold.

    Parameters
    ----------
    rate : float
        Largest (c_p + |v_p|)/L, 1/time.

    Raises
    ------
    CaseError
        If there is no step, or if a controlled step is too short for the end.
    """
    time = scene.case.time
    speed = rate * max(scene.domain.frame.cell)
    if not (0.0 < rate and scene.materials.most_mass * speed * speed < _MOST_ENERGY):
        limit = limiting(scene, rate)
        raise CaseError(
            f"{limit.key}: {limit.what} would cross {rate:g} cells in a unit of time; are "
            "young, density, velocity and grid.cell one consistent set of numbers?"
        )
    courant = scene.case.courant
    if courant is not None and not time.end * rate < courant * MOST_STEPS:
        limit = limiting(scene, rate)
        raise CaseError(
            f"{limit.key}: {limit.what} crosses {rate:.3g} cells in a unit of time, so that the "
            f"end at {time.end:g} is {time.end * rate / courant:.3g} steps away (at most "
            f"{MOST_STEPS:.0e})"
        )


def require_stable(scene: Scene, dt: float, rate: float) -> None:
    """Refuse a step beyond the limit.

    Parameters
    ----------
    rate : float
        Largest (c_p + |v_p|)/L, 1/time.

    Raises
    ------
    CaseError
        If the Courant number is above `REFUSED`.
    """
    stable = stable_courant(scene.case)
    courant = dt * rate
    # A controlled step of Courant 1 must not be refused for rounding.
    if not courant <= REFUSED * (1.0 + 1e-9):
        safe = min(stable, 0.3)
        text = (
            f"time.step: {dt:g} is a Courant number of {courant:.3g}, beyond the stability limit; "
            f"use at most {stable / rate:.3g} (Courant {stable:g}), or step: {{courant: {safe:g}}}"
        )
        limit = limiting(scene, rate)
        if limit.key.startswith("bodies."):
            text += f". {limit.what} is what is fast ({limit.key})"
        diffusive = [
            name
            for name, material in zip(
                scene.materials.names, scene.materials.parameters, strict=True
            )
            if has(type(material), "diffusivity")
        ]
        if diffusive:
            text += (
                f". The viscosity of {', '.join(diffusive)} counts as well: with cells of h no "
                "step may be above density h^2/(2 dimensions shear-viscosity)"
            )
        raise CaseError(text)


def stability_warning(
    dt: float, rate: float, stable: float, key: str = "time.step"
) -> list[Warned]:
    """Warn of a Courant number above `stable`, by the key path of the step."""
    if dt * rate <= stable * (1.0 + 1e-9):
        return []
    safe = min(stable, 0.3)
    text = (
        f"{key}: {dt:g} is a Courant number of {dt * rate:.3g}; above {stable:g} a free "
        f"surface may become unstable with this shape; {safe / rate:.3g} is safer (Courant "
        f"{safe:g})"
    )
    return [warned("unstable-step", text)]
