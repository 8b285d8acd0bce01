"""Motion that vertices keep: velocity and displacement in the initial configuration.

Weights never change there, so that vertices can keep their velocities. Particles need none of their
own (total Lagrangian method with its state at the vertices). A step is then symplectic Euler
with a constant lumped mass: momentum and angular momentum are conserved to rounding, energy is
bounded, and no particle has a velocity that no vertex sees.
"""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.kernel import inlined, is_empty, is_record
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.data.record import MASS, MOMENTUM

#: Entries of a vertex's record in `VertexMotion.values`: mass, and the first of three components of
#: displacement and velocity. Gathered like a record of `Field.G`, displacements give gradients.
KEPT_MASS, DISPLACEMENT, KEPT_VELOCITY = 0, 1, 5


class VertexMotion(NamedTuple):
    """Velocities and displacements of the vertices, from step to step."""

    values: FloatArray  #: (planes * plane,) float64: Records, at the offsets of `Field.G`.
    #: (fields,) bool: Mask of the velocity fields that keep them, of bodies in the initial
    #: configuration.
    fields: NDArray[np.bool_]


@inlined
def keeps(motion, f):
    """Whether the vertices of velocity field `f` keep their motion; `motion` may be ()."""
    if not is_record(motion):
        return False
    return motion.fields[f]


@inlined
def velocity_before(motion, kept, G, r, d, inverse):
    """Component `d` of the velocity of the vertex at `r`, at the step's beginning.

    It is the vertex's own where it is `kept`, else momentum times `inverse`, 1 over the mass.
    """
    if not is_record(motion):
        return G[r + MOMENTUM + d] * inverse
    return motion.values[r + KEPT_VELOCITY + d] if kept else G[r + MOMENTUM + d] * inverse


@inlined
def momentum_before(motion, kept, G, r, d):
    """Component `d` of the momentum of the vertex at `r`, at the step's beginning."""
    if not is_record(motion):
        return G[r + MOMENTUM + d]
    return G[r + MASS] * motion.values[r + KEPT_VELOCITY + d] if kept else G[r + MOMENTUM + d]


@inlined
def grid_rate(relaxation, motion, f):
    """Rate at which field `f` takes the grid's velocity, see `pgimp.kernels.loads.loads.given`.

    Vertices that keep their motion gain all of what conditions add to their velocities.
    """
    if not is_record(motion):
        return relaxation
    if is_empty(relaxation):
        return inf if motion.fields[f] else 0.0
    return inf if motion.fields[f] else relaxation
