"""What the entries of all shapes have in common, and the kernels' view of a shape."""

from typing import Literal

from pydantic import Field

from pgimp.case.base import Count, Model
from pgimp.kernels.jit import exact, specialise


class Shape(Model):
    """Base of the entries ``method``."""

    particles_per_cell: tuple[Count, ...] = Field(
        description="particles per cell along each direction"
    )
    volume: Literal["tracked", "initial"] = Field(
        default="tracked",
        description="volume in the internal force (16): tracked, det(F) times the initial one, "
        "or the initial one throughout, as in the paper's MPM and GIMP runs",
    )


def first(shape, d, xi):
    """First vertex of the support along direction `d`; `xi` in cells from the grid's origin."""


@exact(first)  # all kernels must find the same layer, whatever the code around
def _first(shape, d, xi):
    return shape.instance_class.first


def weights(shape, d, f):
    """Weights and cell-scaled gradients of the support's vertices, two tuples."""


@specialise(weights)
def _weights(shape, d, f):
    return shape.instance_class.weights
