"""Advice on configuration and method, for ``pgimp check``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.body import has_means
from pgimp.case.motion.moving_boxes import clearance, faces_with_condition, instants, moving_boxes
from pgimp.physics.loads.motion import RigidMotion
from pgimp.scene.checks import nearness
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.sanity import strains
from pgimp.scene.liquids import is_gas, only_liquids, reflecting

if TYPE_CHECKING:
    from pgimp.case.body import Body
    from pgimp.case.schema import Case

#: Displacement in cells, and strain, above which the configuration matters.
_FAR, _MUCH = 0.5, 0.05

#: Angle above which lost spin is noticeable; strain above which particle sizes matter.
_TURN, _LARGE = 1.0, 0.15

#: Poisson's ratio above which volumetric locking occurs.
_LOCKS = 0.45


def advice(case: Case, bodies: Sequence[BodyFacts]) -> list[str]:
    """Return advice on configuration and method that give less error or cost for this case.

    None if they are on or near a front of docs/error-against-cost.md. The bodies' motion is judged
    before the run: whether they move, turn, or are strained by loads.
    """
    began = _configuration(case, bodies)
    sizes = () if began else _sizes(case, bodies)
    spin = [*_spin(case), *_idle(case)]
    shapes = [*_points(case, bodies), *_wide(case, bodies), *_liquid(case), *_gas(case)]
    return [*began, *shapes, *spin, *sizes]


def _configuration(case: Case, bodies: Sequence[BodyFacts]) -> list[str]:
    """Advise the initial configuration for bodies that move, turn or stretch.

    Only for elastic bodies; bodies that meet without a contact law would stick together.
    """
    if not all(_fits(case, body) for body in case.bodies.values()):
        return []
    if case.outflow or nearness.meet(case):
        return []
    if "contact" in case.output.grid:
        return []
    moved = [
        body.name
        for body in bodies
        if _moves(case, body) or max(strains(case, body).values()) > _MUCH
    ]
    if not moved:
        return []
    them = "it moves or deforms" if len(moved) == 1 else "they move or deform"
    dear = "; a step takes longer while they are in touch" if _hit(case) else ""
    return [
        f"bodies: {_listed(moved)}: elastic, and {them}: with formulation: total-lagrangian "
        "vibrations and spin last, nothing can tear, and steps need not be shorter as bodies "
        f"move{dear}"
    ]


def _points(case: Case, bodies: Sequence[BodyFacts]) -> Iterator[str]:
    """Advise on point particles that cross cells; with `affine` there is a warning."""
    crossing = [b.name for b in bodies if _moves(case, b) and _current(case, b.name)]
    if crossing and case.method.is_point and not case.method.affine:
        yield (
            f"method.shape: {case.method.name}: {_listed(crossing)} will cross cells, where "
            "points get forces without mass; boxes (gimp) do not, and affine: true "
            "makes them more accurate"
        )


def _wide(case: Case, bodies: Sequence[BodyFacts]) -> Iterator[str]:
    """Advise on wide shapes of moving elastic bodies, except nearly incompressible ones."""
    moving = [
        body.name
        for body in bodies
        if _moves(case, body)
        and case.materials[case.bodies[body.name].material].ELASTIC
        and getattr(case.materials[case.bodies[body.name].material], "poisson", 0.0) < _LOCKS
    ]
    if moving and case.method.wide:
        yield (
            f"method.shape: {case.method.shape}: {_listed(moving)}: elastic, and moves: boxes "
            "(finite-gimp) have the same error in waves, impact and shear in a tenth to half the "
            "time"
        )


def _liquid(case: Case) -> Iterator[str]:
    """Advise walls that reflect and do not let go, where all is liquid."""
    if not only_liquids(case):
        return
    could = any(face.mirrors and not face.releases for face in case.boundaries.values())
    if getattr(case.method, "wall", "") == "ghost" and could and not case.method.ends:
        yield (
            "method.wall: ghost: liquids lose height and motion at walls: in 20 periods of "
            "sloshing, 16 cells deep, 1.1 % of the level and a third of the amplitude; with wall: "
            "auto, the default, 0.05 % and a seventh, for a tenth more time a step"
        )
    for name, face in case.boundaries.items():
        if face.releases and case.gravity is not None:
            yield (
                f"boundaries.{name}: unilateral: liquids crowd at walls that let go: in ten "
                "periods of sloshing 3.6 % of the level are lost, at slip ones 0.05 %; what a "
                "slip wall pulls is cut off by the liquid itself, which has no tension"
            )


def _gas(case: Case) -> Iterator[str]:
    """Advise on what keeps a gas under pressure still: mean dilatation, and walls that reflect."""
    gases = [name for name, body in case.bodies.items() if is_gas(case.materials[body.material])]
    if case.dimensions == 1 or not gases:
        return
    causes = [
        f"{name} is pointwise" for name in gases if not has_means(case.bodies[name], case.method)
    ]
    causes += [
        f"{name} does not reflect"
        for name, face in case.boundaries.items()
        if not (face.joins or face.absorbs) and name not in reflecting(case)
    ]
    if causes:
        yield (
            f"method.volumetric: a gas under pressure, and {'; '.join(causes)}: eddies grow out of "
            "rounding, about tenfold in the time of a wave across 20 cells: air at rest in a box "
            "of 20 x 4 cells lost 17 % of its pressure in 20 such times; with volumetric: b-bar "
            "and walls that all reflect (wall: mirror) it rests"
        )


def _spin(case: Case) -> Iterator[str]:
    """Advise on bodies that turn without `affine`."""
    turning = [
        name
        for name, body in case.bodies.items()
        if isinstance(body.velocity, RigidMotion)
        and body.formulation == "updated-lagrangian"
        and np.linalg.norm(body.velocity.rotation.rate) * case.time.end > _TURN
    ]
    if turning and not case.method.affine:
        yield (
            f"method.affine: {_listed(turning)} will turn, and lose spin without it: after a turn "
            "a block of 12 cells is off by 12 to 27 % of its radius, with affine: true by 1.3 %"
        )


def _idle(case: Case) -> Iterator[str]:
    """Advise on transfer options of particles' velocities where no particle carries one."""
    if any(body.formulation == "updated-lagrangian" for body in case.bodies.values()):
        return
    used = {"affine": case.method.affine, "relaxation": case.method.relaxation not in (0.0, "auto")}
    idle = [f"method.{name}" for name, on in used.items() if on]
    if idle:
        yield (
            f"{' and '.join(idle)}: without effect in the initial configuration, where vertices "
            "keep the velocities"
        )


def _sizes(case: Case, bodies: Sequence[BodyFacts]) -> Iterator[str]:
    """Advise on strong compression or tension of boxes of constant size."""
    strained = [
        body.name
        for body in bodies
        if case.materials[case.bodies[body.name].material].ELASTIC
        and _current(case, body.name)
        and max(strains(case, body).values()) > _LARGE
    ]
    if strained and case.method.keeps_size:
        yield (
            f"method.shape: loads strain {_listed(strained)} by more than {_LARGE:.0%}, and boxes "
            f"of {case.method.name} keep their size, so that errors stay near a per cent "
            "however small the cells; those of finite-gimp follow, at 1.2 times the cost"
        )


def _moves(case: Case, body: BodyFacts) -> bool:
    """Whether a body moves by more than a part of a cell."""
    return body.top_speed * case.time.end > _FAR * min(case.grid.cell)


def _hit(case: Case) -> bool:
    """Whether bodies meet under `contact`, or meet unilateral walls."""
    if case.contact:
        return True
    near, boxes = nearness.reach(case), moving_boxes(case, instants(case))
    return any(
        condition.approaches
        and clearance(case, axis, side, box.low[:, axis], box.high[:, axis]).min() < near[axis]
        for _, condition, axis, side in faces_with_condition(case)
        for box in boxes
    )


def _current(case: Case, name: str) -> bool:
    return case.bodies[name].formulation == "updated-lagrangian"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(map(repr, names[:3])) + " and others" * (len(names) > 3)


def _fits(case: Case, body: Body) -> bool:
    """Whether a body is elastic and in the current configuration."""
    return body.formulation == "updated-lagrangian" and case.materials[body.material].ELASTIC
