"""Rules of scenes: shape, particles a cell, affine transfer, step and contact."""

from __future__ import annotations

from pgimp.case.choices.body_rules import locks
from pgimp.case.choices.rules import Rule

#: Strains above which the size of boxes matters, and above which bars tear.
LARGE, TEARS = 0.15, 0.5

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
        "all bodies in the initial configuration",
        lambda scene: scene.all_initial,
        "energy lasts at any stable step, also where bodies meet",
        "the same error in half the time, where bodies meet in 0.53 to 0.95 of it; a cantilever "
        "keeps its energy at 0.03 to 0.7; a block that bounces loses 302 J, at 0.3 337 J, and its "
        "edges sink in by 0.021 cells, not 0.014, on cells twice as large by 0.05, not 0.03; a "
        "ball that slips gains 1.6 % less spin",
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
        lambda body, initial: body.kind == "gas" or locks(body),
    ),
    Rule(
        "courant",
        0.3,
        "else",
        lambda scene: True,
        "longer steps disturb free surfaces in the current configuration",
        "disks that meet lose 7.2 % of their energy at 0.2, 7.6 % at 0.3, 8.1 % at 0.5",
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
        "liquids and gases alone: mirrors at walls that hold; else ghosts",
        lambda scene: True,
        "boxes that reach past a wall are lost there",
        "20 periods of sloshing lose 0.05 % of the level, with ghosts 1.1 %; a gas at rest in a "
        "box stays so, see `volumetric`",
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
