"""Sanity checks of a case before the run, mostly of its units."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.case.motion.moving_boxes import held_at
from pgimp.case.outflow import sinks
from pgimp.physics.contact.base import UNILATERAL
from pgimp.physics.variation import Variation
from pgimp.physics.variation.randomfield import RandomVariation
from pgimp.scene.checks.facts import BodyFacts, Findings
from pgimp.scene.checks.supports import own_weight
from pgimp.scene.checks.units import unlikely
from pgimp.scene.checks.warned import Warned, warned
from pgimp.schema.tables import VectorFunction
from pgimp.schema.time_functions import TimeFunction

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.physics.loads.turning import Turning

#: Greatest plausible strain of an elastic solid by loads.
_MOST_STRAIN = 0.5
#: Durations of runs in wave transits: enough for waves to matter, few enough for explicit steps.
_FEWEST_TRANSITS, _MOST_TRANSITS = 0.1, 1.0e6
#: Courant number below which most steps are wasted.
LEAST_COURANT = 0.01
#: Cells across a thin body, at most; cells between a wall and a face at the wall, at most.
_THIN, _AT_WALL = 1.0 - 1e-9, 0.5
#: Cells along a body's longest side below which `affine` adds a quarter of its energy or more
#: (tests/kernels/test_affine.py).
_FEW = 3.0 - 1e-9
#: Spacings of particles within which a probe's particle lies, with a margin for a file's.
_FAR = 1.0
#: Part of a bounding box by which its corners are moved inwards: regions are half-open.
_INWARDS = 1e-6
AXES = "xyz"


def strains(case: Case, body: BodyFacts) -> dict[str, float]:
    """Return the linear estimates of a body's strains by its loads.

    Parameters
    ----------
    body : BodyFacts
        One of its bodies.

    Returns
    -------
    dict
        The strain by each load, by the load's description; always of weight and velocity.
    """
    c = body.wave_speed
    modulus = body.density * c * c
    found = {
        "by its own weight" + words: strain for words, strain in own_weight(case, body).items()
    }
    found["by stopping its velocity"] = body.top_speed / c
    pulls = [entry for entry in case.tractions.values() if entry.body == body.name]
    if pulls:
        greatest = max(
            max(_greatest(one.traction), _greatest(one.pressure))
            * (one.profile.greatest if one.profile else 1.0)
            for one in pulls
        )
        found["by its tractions"] = greatest / modulus
    moved = [entry.along for entry in case.constraints.values() if entry.body == body.name]
    moved += [one.velocity for one in case.boundaries.values() if hasattr(one, "velocity")]
    turned = [entry.rotation for entry in case.constraints.values() if entry.body == body.name]
    turning = [_rim(rotation, body) * rotation.greatest for rotation in turned if rotation]
    if turning:
        moved.append(tuple(turning))
    if moved:
        speeds = [_greatest(component) for velocity in moved for component in velocity] or [0.0]
        found["by waves of prescribed velocities"] = max(speeds) / c
    return found


def _rim(rotation: Turning, body: BodyFacts) -> float:
    """Greatest distance of the corners of a body's bounding box from the axis."""
    arms = np.zeros((2 ** len(body.low), 3))
    arms[:, : len(body.low)] = [*product(*zip(body.low, body.high, strict=True))]
    arms[:, : len(body.low)] -= rotation.about
    return float(np.linalg.norm(np.cross(rotation.direction, arms), axis=1).max())


def _greatest(load: Any) -> float:
    """Return the greatest size over time of a number or vector, constant or over time."""
    if load is None:
        return 0.0
    values = [load]
    if isinstance(load, TimeFunction | VectorFunction):
        values = [value for _, value in load.rows]
    return max(float(np.linalg.norm(value)) for value in values)


def body_warnings(
    case: Case, body: BodyFacts, duration: float, settles: bool = False
) -> Iterator[Warned]:
    """Yield warnings about a body.

    Parameters
    ----------
    body : BodyFacts
        One of its bodies.
    duration : float
        Duration of the run.
    settles : bool
        Whether the start or a stage comes to rest: then the time may be as short as one likes.
    """
    if max(strains(case, body).values()) > _MOST_STRAIN:
        yield warned(
            "load-strain",
            f"bodies.{body.name}: loads of the order of the stiffness; are the units of young, "
            "density, gravity, velocity, tractions and grid one consistent set (mm with MPa wants "
            "tonnes)?",
        )
    yield from unlikely(case, body)
    yield from _swallowed(case, body)
    transits = duration * body.wave_speed / body.extent
    if transits < _FEWEST_TRANSITS and not settles:
        yield warned(
            "short-run",
            f"time.end: until then a wave crosses only {transits:.2g} of {body.name}; is it in the "
            "unit of time that belongs to young, density and grid?",
        )
    elif transits > _MOST_TRANSITS:
        yield warned(
            "long-run",
            f"time.end: waves cross {body.name} {transits:.3g} times until then, too often for a "
            "method that follows each; is it in the unit of time that belongs to young, density "
            "and grid? What is slow can be shortened, as long as it stays slow for the waves",
        )


def _swallowed(case: Case, body: BodyFacts) -> Iterator[Warned]:
    """Warn of sinks that contain all corners of a body's bounding box at the start."""
    if case.bodies[body.name].formulation != "updated-lagrangian":
        return
    low, high = np.array(body.low), np.array(body.high)
    near, far = low + _INWARDS * (high - low), high - _INWARDS * (high - low)
    corners = np.array(list(product(*zip(near, far, strict=True))))
    for name, sink in sinks(case.outflow).items():
        if sink.region.contains(corners).all():
            yield warned(
                "sink",
                f"outflow.{name}: contains all of {body.name} at the start, which is gone after "
                "the first step; a sink is to lie where material arrives",
            )


def _coarse(key: str, variation: Variation, case: Case) -> Iterator[Warned]:
    """Yield a warning if a random field changes from one cell to the next."""
    for part in variation.parts():
        if isinstance(part, RandomVariation):
            lengths = part.random.lengths(case.dimensions)
            for length, cell in zip(lengths, case.grid.cell, strict=True):
                if length < cell:
                    yield warned(
                        "random-length",
                        f"{key}: the correlation length {length:g} of the random field is below "
                        f"the cell {cell:g}, so that neighbours hardly know of each other and "
                        "results depend on the cells; take cells of a third of it or less",
                    )
                    return


def case_warnings(case: Case, found: Findings) -> Iterator[Warned]:
    """Yield warnings about the case: thin bodies, idle probes and tractions, unsuitable methods.

    Parameters
    ----------
    found : Findings
        See `pgimp.scene.checks.facts.examine`.
    """
    if case.method.affine and case.method.is_point:
        yield warned(
            "affine-points",
            f"method.affine: with points ({case.method.name}) it can make energy from nothing, "
            "the more the smaller the step; take it with boxes (shape: gimp)",
        )
    for name, entry in case.materials.items():
        for path, variation in entry.variations.items():
            yield from _coarse(f"materials.{name}.{'.'.join(path)}", variation, case)
    pressed = _pressed(case)
    if pressed and case.method.is_point:
        yield warned(
            "contact-points",
            f"contact: of points ({case.method.name}) the gap between bodies is known to half a "
            "cell only, and jumps as they move; take boxes (shape: gimp)",
        )
    for body in found.bodies:
        cells = [size / cell for size, cell in zip(body.sizes, case.grid.cell, strict=True)]
        thin = [f"{n:.2g} along {AXES[d]}" for d, n in enumerate(cells) if n < _THIN]
        if thin:
            yield warned(
                "thin-body",
                f"bodies.{body.name}.region: fewer cells across it than one, {', '.join(thin)}; "
                "stress and bending need several: smaller cells (grid.cell)",
            )
        if thin and body.name in pressed:
            yield warned(
                "thin-contact",
                f"contact: '{body.name}' has both its sides in one cell, so that what it meets "
                "finds no direction to push in: smaller cells (grid.cell)",
            )
        moves = case.bodies[body.name].formulation == "updated-lagrangian"
        if moves and case.method.affine and max(cells) < _FEW:
            yield warned(
                "few-cells",
                f"method.affine: '{body.name}' is only {max(cells):.2g} cells long; on so few, "
                "its energy grows by a quarter or more when it vibrates, whatever the step: "
                "smaller cells (grid.cell)",
            )
    spacing = max(
        cell / n for cell, n in zip(case.grid.cell, case.method.particles_per_cell, strict=True)
    )
    for name, probe in case.probes.items():
        away = found.away[name]
        if hasattr(probe, "place"):
            if away >= 1.0:
                yield warned(
                    "probe-place",
                    f"probes.{name}.place: no particle within a cell of it at the start; its lines "
                    "are empty until material comes there",
                )
        elif away > _FAR * spacing:
            yield warned(
                "probe-far",
                f"probes.{name}.at: the closest particle of '{probe.body}' is {away:.3g} away, "
                f"where particles are {spacing:.3g} apart",
            )
    yield from _ineffective_tractions(case)


def _pressed(case: Case) -> set[str]:
    """Names of the bodies that may meet others under a friction law."""
    names: set[str] = set()
    for entry in case.contact:
        if entry.law.kind == UNILATERAL:
            names.update(case.bodies if entry.bodies == "all" else entry.bodies)
    return names


def _ineffective_tractions(case: Case) -> Iterator[Warned]:
    """Yield the tractions that a wall supports entirely."""
    for name, entry in case.tractions.items():
        condition = case.boundaries.get(entry.face or "")
        if condition is None:
            continue
        axis, side = entry.axis, entry.side
        region = case.bodies[entry.body].region.bounds()[side > 0][axis]
        wall = (case.grid.corner if side > 0 else case.grid.origin)[axis]
        if abs(region - wall) <= _AT_WALL * case.grid.cell[axis] and all(
            held_at(condition, axis, side)[: case.dimensions]
        ):
            yield warned(
                "idle-traction",
                f"tractions.{name}: the face {entry.face} of '{entry.body}' lies at the domain's, "
                "whose condition holds it: the traction moves nothing",
            )


def small_step_warning(dt: float, rate: float, key: str = "time.step") -> list[Warned]:
    """Warn of a step far below the stable one.

    Parameters
    ----------
    rate : float
        Largest (c_p + |v_p|)/L, 1/time.
    key : str
        Key path of the step.
    """
    if dt * rate >= LEAST_COURANT:
        return []
    text = (
        f"{key}: {dt:g} is a Courant number of {dt * rate:.3g}; step: {{courant: 0.3}} takes "
        f"{0.3 / (dt * rate):.3g} times fewer steps, if young, density and grid are right"
    )
    return [warned("short-step", text)]
