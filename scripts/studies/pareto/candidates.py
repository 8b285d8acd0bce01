"""The methods that scripts/pareto measures: shape, transfer, configuration, particles, step."""

from typing import NamedTuple


class Method(NamedTuple):
    """A method of pgimp: shape, transfer, configuration, particles a cell, step, mass.

    The Courant number ``auto`` leaves the step to pgimp.
    """

    shape: str
    affine: bool = False
    initial: bool = False
    per_cell: int = 2
    courant: float | str = 0.3
    mass: str = "lumped"

    @property
    def label(self):
        """Name in pictures and tables: what is not said is current, 2 a cell and 0.3."""
        words = [self.shape]
        words += ["affine"] * self.affine + ["initial"] * self.initial
        words += ["1 a cell"] * (self.per_cell == 1) + ["auto"] * (self.courant == "auto")
        words += ["averaged"] * (self.mass == "averaged")
        return ", ".join(words)


SHAPES = (
    "mpm", "gimp", "finite-gimp", "cpdi", "cpdi-corners", "fuzzy-nearest", "fuzzy-constant",
    "bspline-quadratic", "bspline-cubic",
)  # fmt: skip
#: In the initial configuration sizes do not follow the deformation: `finite-gimp` is `gimp`, and
#: `fuzzy-constant` is `bspline-cubic`.
OF_START = ("mpm", "gimp", "cpdi", "bspline-quadratic", "bspline-cubic")
#: Points that move are stable up to 0.12 only (docs/hard-cases.md); in the initial configuration
#: they do not come nearer to the vertices than they are at the start.
POINTS = 0.1
METHODS = (
    *(
        Method(shape, affine, courant=POINTS if shape == "mpm" else 0.3) for shape in SHAPES
        for affine in (False, True)
    ),
    *(Method(shape, affine, True) for shape in OF_START for affine in (False, True)),
    *(
        Method(shape, affine, initial, 1)
        for shape, initial in (("gimp", False), ("cpdi", False), ("gimp", True))
        for affine in (False, True)
    ),
    Method("gimp", True, courant="auto"), Method("cpdi", True, courant="auto"),
    Method("gimp", False, True, courant="auto"), Method("gimp", True, True, courant="auto"),
    *(Method("gimp", False, True, courant=courant, mass="averaged") for courant in (0.3, "auto")),
)  # fmt: skip
