"""The rules by which a method is chosen: one table, of which the page 'Which method' is made.

Of the rules of a key the first that fits is taken. `figure` has what supports it, measured where
the page says.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from pgimp.case.choices.facts import BodyChoice

#: Strain above which a metal's steps in the initial configuration become too short.
METAL_STRAIN = 0.1
#: Poisson's ratio above which solids lock.
LOCKS = 0.45
#: Strains above which the size of boxes matters, and above which bars tear.
LARGE, TEARS = 0.15, 0.5


class Rule(NamedTuple):
    """A choice, when it is taken, and why."""

    key: str  #: Of the body, or of `method` and `time`.
    value: Any
    when: str  #: The condition in words.
    fits: Callable[[Any], bool]
    reason: str
    figure: str
    page: str  #: As links between pages have it.
    #: Of the scene's keys, which bodies need it: by a body, and whether it is in the initial
    #: configuration. The others have it because of these.
    whose: Callable[[BodyChoice, bool], bool] | None = None


def _body(body: BodyChoice, *kinds: str) -> bool:
    return body.kind in kinds


def _locks(body: BodyChoice) -> bool:
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
        lambda it: it[2].dimensions > 1 and _locks(it[0]),
        "nearly incompressible and plastic solids lock without",
        "a strip on clay bears 5.06 c, without 7.24 (exact 5.14); a beam of ratio 0.4999 is 1 % "
        "too stiff, without 57 to 69 %",
        "hard-cases.md#locking",
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

#: Of the scene.
OF_SCENES: tuple[Rule, ...] = (
    Rule(
        "shape",
        "finite-gimp",
        "a gas",
        lambda scene: scene.some("gas") and not scene.some("liquid", "soil", "grains"),
        "boxes that grow with the gas leave no gaps",
        "Sod's tube; copper behind shocks to 0.01 %",
        "soils-and-fluids.md#measured",
        lambda body, initial: body.kind == "gas",
    ),
    Rule(
        "shape",
        "cpdi",
        f"solids in the current configuration strained by more than {TEARS:g}, beside no flow",
        lambda scene: (
            scene.strain > TEARS
            and scene.some("elastic", "metal", "other")
            and not scene.some("liquid", "soil", "grains", "gas", "metal")
        ),
        "bars do not tear up to nearly three times their length",
        "`gimp` tears at 1.6 times the length, `cpdi` at 3",
        "hard-cases.md#reasons",
        lambda body, initial: not initial and body.strain > TEARS,
    ),
    Rule(
        "shape",
        "finite-gimp",
        f"solids strained by more than {LARGE:g} there, metals too, beside no flow",
        lambda scene: (
            scene.strain > LARGE
            and scene.some("elastic", "metal", "other")
            and not scene.some("liquid", "soil", "grains", "gas")
        ),
        "boxes follow the deformation",
        "a column's stress at 16 % is right to 0.09 %, with `gimp` to 0.9 %, at 1.2 of the cost; "
        "Taylor's bar is within what was published, with `gimp` 4 % outside",
        "methods.md#every-method",
        lambda body, initial: not initial and body.strain > LARGE,
    ),
    Rule(
        "shape",
        "gimp",
        "else",
        lambda scene: True,
        "the cheapest shape that is as accurate as any there",
        "waves, spin and bending as `finite-gimp`, `cpdi`, in 0.8 to 0.9 of their time",
        "methods.md#every-method",
    ),
    Rule(
        "particles-per-cell",
        1,
        "in 1D, all bodies in the initial configuration",
        lambda scene: scene.dimensions == 1 and scene.all_initial,
        "strain is even along a cell",
        "the same motion as with two, in half the time, and stress in the middle of cells",
        "methods.md#the-initial-configuration",
    ),
    Rule(
        "particles-per-cell",
        2,
        "else, along each direction",
        lambda scene: True,
        "with one, too much is lost",
        "one a cell loses 27 % of a swing and all spin in a turn, and in the initial "
        "configuration has modes that strain nothing",
        "methods.md#reasons",
    ),
    Rule(
        "affine",
        False,
        "in the current configuration only liquids and grains, any of them on a face that holds "
        "it in every direction",
        lambda scene: (
            any(b.sticks for b in scene.bodies if b.kind in ("liquid", "grains"))
            and not scene.some("elastic", "metal", "soil", "gas", "other")
        ),
        "particles at such a face go without the gradient of what is held there",
        "Poiseuille's flow is right to 0.17 %, with `affine` to 2 %; Bagnold's to 1.8, not 2.1 %",
        "methods.md#what-is-chosen",
        lambda body, initial: body.sticks and body.kind in ("liquid", "grains"),
    ),
    Rule(
        "affine",
        True,
        "any other body in the current configuration",
        lambda scene: not scene.all_initial,
        "spin and waves last longer",
        "spin lost in a turn 0.02 %, not 42 %; swing 0.06 %, not 0.5 %; at 1.18 of the cost",
        "methods.md#reasons",
        lambda body, initial: not initial,
    ),
    Rule(
        "affine",
        False,
        "else",
        lambda scene: True,
        "vertices keep the velocities",
        "without effect in the initial configuration",
        "methods.md#the-initial-configuration",
    ),
    Rule(
        "courant",
        "auto",
        "all bodies in the initial configuration, in a scene where nothing meets",
        lambda scene: scene.all_initial and not scene.meets,
        "energy lasts at any stable step",
        "half the time at the same error; a cantilever keeps its energy at 0.03 to 0.7",
        "error-against-cost.md",
    ),
    Rule(
        "courant",
        0.2,
        "a gas; or 3D with `volumetric: b-bar`",
        lambda scene: scene.some("gas") or (scene.dimensions == 3 and any(scene.means)),
        "steps that are stable with mean dilatation, or behind shocks",
        "largest stable 0.26 with two particles a cell and direction",
        "hard-cases.md#the-largest-stable-steps",
        lambda body, initial: body.kind == "gas" or _locks(body),
    ),
    Rule(
        "courant",
        0.3,
        "else",
        lambda scene: True,
        "in longer steps edges sink in deeper where bodies meet, and free surfaces are disturbed",
        "a block that bounces, in the initial configuration, loses 337 J at 0.3 and 301 J at 0.66, "
        "and its edges sink in by 0.014 and 0.021 cells, on coarser ones by 0.03 and 0.05; disks "
        "in the current one lose 7.2 % at 0.2, 7.6 % at 0.3, 8.1 % at 0.5",
        "methods.md#what-is-chosen",
    ),
)

#: What `auto`, the default of these keys, takes: said here for the page alone.
BY_MATERIAL: tuple[Rule, ...] = (
    Rule(
        "pic-damping",
        "auto",
        "soil and grains: 0.002 c/h to the body's own motion; liquids alone: 0.01 nu/h^2",
        lambda scene: True,
        "damps what the grid cannot resolve",
        "sand comes to rest: 0.0002 of its greatest kinetic energy, without 0.014",
        "soils-and-fluids.md#measured",
    ),
    Rule(
        "wall",
        "auto",
        "liquids alone: mirrors at walls that hold; else ghosts",
        lambda scene: True,
        "boxes of liquids that reach past a wall are lost there",
        "20 periods of sloshing lose 0.05 % of the level, with ghosts 1.1 %",
        "soils-and-fluids.md#measured",
    ),
)

#: Of bodies that may meet.
CONTACT: tuple[Rule, ...] = (
    Rule(
        "contact",
        "frictionless",
        "bodies that may meet or touch, rigid ones too; not liquids, gases, grains and soils among "
        "each other, which flow together",
        lambda scene: True,
        "bodies meet, slide and part",
        "without contact they would be bonded, from two cells apart; `contact: bonded` says "
        "that this is meant",
        "contact.md",
    ),
)


def rule_of(rules: tuple[Rule, ...], key: str, of: object) -> Rule:
    """Return the first rule of a key that fits a body or a scene; one always does."""
    return next(rule for rule in rules if rule.key == key and rule.fits(of))
