"""Rules of bodies: formulation, mass and volumetric treatment."""

from __future__ import annotations

from pgimp.case.choices.facts import BodyChoice
from pgimp.case.choices.rules import Rule

#: Strain above which a metal's steps in the initial configuration become too short.
METAL_STRAIN = 0.1
#: Poisson's ratio above which solids are too stiff as they bend on few cells.
LOCKS = 0.35


def _body(body: BodyChoice, *kinds: str) -> bool:
    return body.kind in kinds


def locks(body: BodyChoice) -> bool:
    """Whether a body locks with volumes by particle."""
    return body.kind in ("soil", "metal") or (
        body.kind in ("elastic", "other") and body.poisson > LOCKS
    )


#: Of each body.
OF_BODIES: tuple[Rule, ...] = (
    Rule(
        "formulation",
        "updated-lagrangian",
        "stages take out or bring bodies, or it enters by inflow",
        lambda body: body.leaves,
        "particles or parts of the ground come or go",
        "refused, or bonds that jump, in the initial configuration",
        "methods.md#the-initial-configuration",
    ),
    Rule(
        "formulation",
        "updated-lagrangian",
        "a liquid, a gas, grains or soil",
        lambda body: _body(body, "liquid", "gas", "grains", "soil"),
        "it flows, which a grid of the start does not follow",
        "columns of sand run out to 1 to 6 %, a dam break keeps its water to 0.2 %",
        "soils-and-fluids.md#measured",
    ),
    Rule(
        "formulation",
        "updated-lagrangian",
        "a material of one's own that is not declared elastic",
        lambda body: _body(body, "other"),
        "nothing says that its material keeps together",
        "a grid of the start fails where material flows",
        "methods.md#the-initial-configuration",
    ),
    Rule(
        "formulation",
        "updated-lagrangian",
        "a metal with `damage`",
        lambda body: body.fails,
        "it may fail and part",
        "in the initial configuration nothing parts",
        "methods.md#the-initial-configuration",
    ),
    Rule(
        "formulation",
        "updated-lagrangian",
        f"a metal, or clay as one, strained by more than {METAL_STRAIN:g}, or by tools and grips "
        "to several times its yield strain: by their ways over its size, and by those of bodies "
        "of a material that are moved",
        lambda body: _body(body, "metal") and (body.strain > METAL_STRAIN or body.yields),
        "its plastic flow is large",
        "a footing is right to 1.5 %, so to 8.9 %; Taylor's bar has a radius of 7.01 "
        "mm, so 7.38 (published 6.9 to 7.2) in four times the time",
        "metals.md#in-runs",
    ),
    Rule(
        "formulation",
        "updated-lagrangian",
        "it may come to a face that holds what lies on it, and does not let go",
        lambda body: bool(body.wall),
        "it may come to a wall that, in the initial configuration, holds only what lies there at "
        "the start",
        "such a run stops; with `unilateral` the body bounces, in the initial configuration",
        "walls.md",
    ),
    Rule(
        "formulation",
        "total-lagrangian",
        "an elastic body",
        lambda body: _body(body, "elastic"),
        "it keeps together, so that vibrations and spin last and nothing tears",
        "a cantilever keeps 1.003 of its energy for 50 periods, not 0.49; a bounce loses 10 %, not "
        "49 %; a step costs 0.18 to 0.30",
        "methods.md#initial-and-current-configuration",
    ),
    Rule(
        "formulation",
        "total-lagrangian",
        "a metal with small strains",
        lambda body: True,
        "its strains are small, so that it keeps together",
        "as of elastic bodies; a step costs 0.65 to 0.68",
        "methods.md#initial-and-current-configuration",
    ),
)


#: Of the mass of a body in the initial configuration.
MASS: tuple[Rule, ...] = (
    Rule(
        "mass",
        "averaged",
        "an elastic body in the initial configuration, in a scene where nothing settles, and in 2D "
        "and 3D nothing meets",
        lambda it: (
            it[1]
            and it[0].kind == "elastic"
            and not it[2].settles
            and (it[2].dimensions == 1 or not it[2].meets)
        ),
        "waves are then at their speed",
        "a wave of ten cells is four times as accurate, in steps 0.85 times as long; two bars of "
        "20 cells part at 0.974 of the speed at which they meet, not 0.964",
        "waves.md",
    ),
)

#: Of each body, in a scene; `method.volumetric` is `b-bar` where any body needs it.
VOLUMETRIC: tuple[Rule, ...] = (
    Rule(
        "volumetric",
        "b-bar",
        f"2D or 3D, a solid with Poisson's ratio above {LOCKS:g} or that flows plastically, soils "
        "among them",
        lambda it: it[2].dimensions > 1 and locks(it[0]),
        "nearly incompressible and plastic solids lock without",
        "a strip on clay bears 5.06 c, without 7.24 (exact 5.14); a beam of ratio 0.4999 is 1 % "
        "too stiff, without 57 to 69 %; one of 0.4, four cells high, is right to 2 %, without to 6",
        "hard-cases.md#locking",
    ),
    Rule(
        "volumetric",
        "b-bar",
        "2D or 3D, a gas where all bodies are gases or liquids: their walls reflect",
        lambda it: (
            it[2].dimensions > 1
            and it[0].kind == "gas"
            and all(body.kind in ("gas", "liquid") for body in it[2].bodies)
        ),
        "pressure at rest otherwise drives eddies out of rounding",
        "a gas at rest in a box keeps still for 12,000 steps; without it and mirrors, 17 % of the "
        "pressure are lost in 20 travel times",
        "soils-and-fluids.md#fluids-and-gases",
    ),
    Rule(
        "volumetric",
        "pointwise",
        "else, of each body",
        lambda it: True,
        "it does not lock",
        "a step costs 1.1 to 1.2 times as much with `b-bar`, of any body",
        "methods.md#reasons",
    ),
)
