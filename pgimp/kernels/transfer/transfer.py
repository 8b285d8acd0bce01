"""Scatter and gather between a particle and the vertices of its support.

They move records of vertices, see `pgimp.kernels.data.record`. Both transfers are written once for
all dimensions, and factor the sums by direction. In 3D the innermost vertex costs P2G three vector
multiply-adds, and G2P three. Vertices without weight at the support's end are left out. The
innermost direction, along which records follow each other, is unrolled for each number of vertices;
the others are loops.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import specialise
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.transfer.supports import entries
from pgimp.kernels.update.mean_dilatation_weights import factors


class Support(NamedTuple):
    """Support of one of four particles.

    Attributes
    ----------
    buffer
        The supports of the four particles, see `pgimp.kernels.transfer.supports`.
    j : int
        Number of the particle among the four.
    """

    buffer: np.ndarray
    j: int


def last_step(stride):
    """Distance of neighbours along the last direction, given its stride and the following ones.

    In 1D it is the distance of planes, which may hold several fields; else it is a constant.
    """


@specialise(last_step)
def _last_step(stride):
    return (lambda stride: stride[0]) if len(stride) == 3 else (lambda stride: RECORD)


def last_entries(support, d, like, mean):
    """Weights, gradients, arms and factors along the last direction, as many as `like` has."""


@specialise(last_entries)
def _last_entries(support, d, like, mean):
    return lambda support, d, like, mean: (
        entries(support.buffer, d, 0, 0, support.j, like),
        entries(support.buffer, d, 1, 0, support.j, like),
        entries(support.buffer, d, 2, 0, support.j, like),
        factors(mean, support.buffer, d, 0, support.j, like),
    )
