"""A particle driven along a path; strains with prescribed stresses are solved for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pgimp.errors import RunError
from pgimp.utilities.element.march import Array, Element
from pgimp.utilities.element.paths import Path, gradient

#: Newton's method for strains with prescribed stresses.
_MOST_ROUNDS = 40
_DIFFERENCE = 1e-7
_TOLERANCE = 1e-13
_ACCEPTED = 1e-10
_HALVINGS = 60
_LARGEST_STRAIN = 0.1


def follow(
    element: Element, path: Path, values: Array, confine: float, rate: float
) -> tuple[Array, Array, Array]:
    """Drive a particle along a path.

    Parameters
    ----------
    element : Element
        The particle, at rest and undeformed.
    values : (n,) float64
        Values of the path at the end of each step.
    confine : float
        Isotropic pressure applied first, unless it is the initial pressure; strains count from
        there.
    rate : float
        Rate of the value, 1/time.

    Returns
    -------
    rows : (n + 1, columns) float64
        Stress and state before the first step and after each.
    F : (n + 1, D, D) float64
        Deformation gradients.
    times : (n + 1,) float64
        Times since the path's beginning.

    Raises
    ------
    RunError
        If no strain gives the path's prescribed stress, or the material gives no finite stress.
    """
    strains = np.zeros(3)
    if confine != element.material.initial_pressure:
        _confine(element, strains, confine, rate)
    start = strains.copy()
    rows, gradients, times = [element.row.copy()], [element.F.copy()], [0.0]
    before = 0.0
    for value in values:
        dt = abs(value - before) / rate or 1.0 / rate
        added = path.stretch(float(value))
        held = start + added[:3]
        for i in path.free:
            held[i] = strains[i]
        strains = _step(element, held, added[3], path.free, -confine, dt)
        if not np.isfinite(element.row).all():
            raise RunError(
                f"the material gives no finite stress or state at {value:.6g} of the path"
            )
        rows.append(element.row.copy())
        gradients.append(element.F.copy())
        times.append(times[-1] + dt)
        before = value
    return np.array(rows), np.array(gradients), np.array(times)


def _confine(element: Element, strains: Array, pressure: float, rate: float) -> None:
    """Bring a particle from its initial pressure to another isotropic pressure, in ten steps."""
    start = element.material.initial_pressure
    for k in range(1, 11):
        target = -start - (pressure - start) * k / 10.0
        strains[:] = _step(element, strains, 0.0, (0, 1, 2), target, 0.1 / rate)


def _step(
    element: Element, strains: Array, shear: float, free: tuple[int, ...], target: float, dt: float
) -> Array:
    """Do one step to strains; free ones are solved for so that their stress is the target."""
    D, found = element.dimensions, strains.copy()
    across = list(free)
    freed = np.isin(np.arange(3), across).astype(float)

    def stresses(trial: Array) -> Array:
        row, _ = element.tried(gradient(trial, shear, D)[None], dt)
        return row[0, across] - target

    def slopes(at: Array, left: Array) -> Array:
        """Return the derivatives towards the target; sand that opens has none away from it."""
        slope = np.zeros((len(free), len(free)))
        for k, i in enumerate(free):
            moved = at.copy()
            moved[i] += (difference := -_DIFFERENCE if left[k] > 0.0 else _DIFFERENCE)
            slope[:, k] = (stresses(moved) - left) / difference
        return slope

    def steps(slope: Array, left: Array) -> Array:
        step = np.linalg.lstsq(slope, -left, rcond=None)[0]
        return np.clip(step, -_LARGEST_STRAIN, _LARGEST_STRAIN)

    if free:
        left = stresses(found)
        slope = slopes(found, left)
        scale = np.abs(slope).max()
        for _ in range(_MOST_ROUNDS):
            if not np.isfinite(left).all() or scale == 0.0:
                break
            if np.abs(left).max() <= _TOLERANCE * scale:
                break
            step = steps(slope, left)
            trial = found.copy()
            trial[across] += step
            now = stresses(trial)
            # Broyden's update of the slope: exact along the last step.
            if (length := step @ step) > 0.0:
                slope += np.outer(now - left - slope @ step, step) / length
            found, left = trial, now
        if not np.abs(left).max() <= _ACCEPTED * scale:
            # Across a kink, where flow begins or turns: bisection, with all free strains equal.
            found[across] = strains[across] + _halved(
                lambda more: float(stresses(strains + more * freed).mean())
            )
            left = stresses(found)
            scale = max(scale, np.abs(slopes(found, left)).max())
        if not np.abs(left).max() <= _ACCEPTED * scale:
            raise RunError(
                f"no strain across gives a stress of {target:.6g} there: the material has no "
                "stiffness left, or the steps are too long; give more of them (--steps)"
            )
    element.advance(gradient(found, shear, D)[None], dt)
    return found


def _halved(stress: Callable[[float], float]) -> float:
    """Return the zero of a stress that increases with strain, by bisection; 0 if there is none."""
    side = -1.0 if stress(0.0) > 0.0 else 1.0
    near, far = 0.0, side * _DIFFERENCE
    while side * stress(far) < 0.0:
        near, far = far, 2.0 * far
        if abs(far) > _LARGEST_STRAIN * _MOST_ROUNDS:
            return 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (near + far)
        near, far = (middle, far) if side * stress(middle) < 0.0 else (near, middle)
    return far
