"""Strain that a body of a case may come to, at the order of magnitude, by closed forms.

Nothing is run for it: kernels that are not yet compiled would take longer than the whole check, and
the choice may not depend on what is compiled.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from pgimp.case.motion.moving_boxes import TOUCH, Box, clearance, faces_with_condition, instants
from pgimp.physics.loads.motion import RigidMotion
from pgimp.physics.rigid import Motion
from pgimp.schema.tables import VectorFunction
from pgimp.schema.time_functions import TimeFunction

#: Stands for `pgimp.case.schema.Case`, whose module imports the choices.
Case = Any

#: Strain of grips and tools over that at yield, above which a plastic body collapses.
_COLLAPSES = 5.0
#: Stress of loads over that at yield, above which a plastic body does; plastic strain, if hard.
_BEARS, _HARDENS = 1.5, 0.1
#: Length over height from which loads across bend a body.
_SLENDER = 2.0
#: Greatest stress of bending over the load per area, for a ratio of 1: held at one end, at both.
_ONE_END, _BOTH_ENDS = 3.0, 0.5


def greatest(value: Any, below: float = np.inf) -> float:
    """Greatest number in a parameter, which may vary in space as a case writes it; 0 for none."""
    if isinstance(value, float | int):
        return float(value)
    data = value.model_dump() if hasattr(value, "model_dump") else value
    return max((x for x in _numbers(data) if 0.0 <= x < below), default=0.0)


def _numbers(data: Any) -> Iterator[float]:
    if isinstance(data, dict):
        data = tuple(data.values())
    if isinstance(data, tuple | list):
        for item in data:
            yield from _numbers(item)
    elif isinstance(data, float | int) and not isinstance(data, bool):
        yield float(data)


def _most(load: Any, times: np.ndarray) -> np.ndarray:
    """Greatest magnitudes of a load over time: a number or vector, constant or of time."""
    if isinstance(load, VectorFunction | TimeFunction):
        return np.abs([load.value(float(t)) for t in times]).max(axis=0)
    return np.abs(np.array(load, float))


class Strained(NamedTuple):
    """A solid body and what may strain it."""

    case: Case
    box: Box
    material: Any
    metal: bool
    speed: float  #: At which it meets others or faces.

    @property
    def _size(self) -> np.ndarray:
        return np.maximum(self.box.high[0] - self.box.low[0], 1e-300)

    @property
    def strain(self) -> float:
        """The greatest strain."""
        density, young = greatest(self.material.density), self._young
        strain = self.grips
        if young:
            strain = max(strain, self.speed * (density / young) ** 0.5, self.stress / young)
        if self.metal and self._strength:  # Johnson's damage number
            strain = max(strain, density * self.speed**2 / self._strength)
        return strain if isfinite(strain) else 1.0

    @property
    def yields(self) -> bool:
        """Whether a metal flows far beyond its strain at yield."""
        strength, grips = self._strength, self.grips
        if not self.metal:
            return False
        beyond = max(0.0, self.stress - strength)
        hardening = greatest(getattr(self.material, "hardening", 0.0))
        collapses = beyond > (_BEARS - 1.0) * strength and beyond > _HARDENS * hardening
        far = self._young * grips > _COLLAPSES * strength
        return far or (collapses and strength > 0.0) or not isfinite(grips)

    @property
    def _young(self) -> float:
        return greatest(getattr(self.material, "young", None))

    @property
    def _strength(self) -> float:
        return greatest(
            getattr(self.material, "yield_stress", None) or getattr(self.material, "a", None)
        )

    @property
    def grips(self) -> float:
        """Strain by prescribed motions of its parts, and by tools."""
        case, box, sizes = self.case, self.box, self._size
        ways, end = [np.zeros(case.dimensions)], case.time.end
        for entry in case.constraints.values():
            if entry.body == box.name and not entry.field:
                ways.append(np.array([v or 0.0 for v in entry.displacement(end)]))
        held = len(ways) > 2 or any(  # one grip alone takes the body with it
            clearance(case, axis, side, box.low[0, axis], box.high[0, axis]) < 1.0
            for _, _, axis, side in faces_with_condition(case)
        )
        apart = np.ptp(ways, axis=0) if held else np.zeros(case.dimensions)
        for entry in case.constraints.values():  # tools of a material
            if self.metal and entry.body != box.name and not entry.field:
                way = np.array([v or 0.0 for v in entry.displacement(end)])
                apart = np.maximum(apart, np.abs(way))
        for body in case.rigid_bodies.values():
            if isinstance(body.rigid, Motion) and body.rigid.moves:
                way = np.array([body.rigid.displacement(float(t)) for t in instants(case)])
                way = np.abs(way[:, : case.dimensions]).max(axis=0)
                apart = np.maximum(apart, way * sizes / np.minimum(sizes, _wide(body.region, way)))
        return float((apart / sizes).max())

    @property
    def stress(self) -> float:
        """Greatest stress of weight, tractions and spin, with bending where the body is slender."""
        case, size, times = self.case, self._size, instants(self.case)
        density, load = greatest(self.material.density), np.zeros(case.dimensions)
        if case.gravity is not None:
            load += density * _most(case.gravity, times) * size
        for entry in case.tractions.values():
            if entry.body != self.box.name:
                continue
            if entry.traction is not None:
                load += _most(entry.traction, times)
            elif entry.pressure is not None:
                pressure = float(_most(entry.pressure, times))
                axes = slice(None) if entry.face is None else "xyz".index(entry.face[0])
                load[axes] += pressure
        found = max(load[d] * self._bent(d) for d in range(case.dimensions))
        velocity = case.bodies[self.box.name].velocity
        if isinstance(velocity, RigidMotion):
            rate = np.linalg.norm(velocity.rotation.rate)
            found = max(found, 0.5 * density * (0.5 * rate * size.max()) ** 2)
        return float(found)

    def _bent(self, axis: int) -> float:
        """Factor by which bending makes the stress of a load along an axis greater, at least 1."""
        size, low, high = self._size, self.box.low[0], self.box.high[0]
        found = 1.0
        for along in range(len(size)):
            slender = size[along] / size[axis]
            ends = set(self._held(along, low, high))
            if along == axis or slender < _SLENDER or not ends or set(self._held(axis, low, high)):
                continue
            found = max(found, (_ONE_END if len(ends) == 1 else _BOTH_ENDS) * slender**2)
        return found

    def _held(self, along: int, low: np.ndarray, high: np.ndarray) -> Iterator[int]:
        """Ends of the body along an axis that a face or a constraint holds, -1 and 1."""
        for _, _, axis, side in faces_with_condition(self.case):
            if axis == along and clearance(self.case, axis, side, low[axis], high[axis]) <= TOUCH:
                yield side
        for entry in self.case.constraints.values():
            known = not any(part.FROM_FILE for part in entry.region.simple())
            if entry.body == self.box.name and known:
                ends = [np.array(end, float)[along] for end in entry.region.bounds()]
                middle = 0.5 * (low + high)[along]
                if ends[1] <= middle or ends[0] >= middle:
                    yield -1 if ends[1] <= middle else 1


def _wide(region: Any, way: np.ndarray) -> float:
    """Width of a tool across its way: as deep it strains what it sinks into."""
    if any(part.FROM_FILE for part in region.simple()):
        return float("inf")
    low, high = (np.array(end, float) for end in region.bounds())
    across = (high - low)[way < way.max()]
    return float(across.min()) if across.size else float("inf")
