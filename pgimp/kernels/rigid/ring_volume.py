"""Neighbourhoods of vertices in axisymmetry: rings, whose volumes and surfaces are all round."""

from math import pi

from pgimp.jit.kernel import inlined
from pgimp.kernels.grid.faces import wall_sides
from pgimp.kernels.transfer.first_vertex import is_axial


@inlined
def ring_volume_factor(frame, number, sides):
    """Way of a vertex's neighbourhood round the axis; 1 outside of axisymmetry.

    Times the area of its section it is its volume. The neighbourhood is weighted with the vertex's
    tent, of which walls and the axis leave the half with its middle a third of a cell away.

    Parameters
    ----------
    number : (int, int, int)
        The vertex.
    sides : (int, int, int)
        Its walls, see `wall_sides`.
    """
    if not is_axial(frame):
        return 1.0
    cells = number[0] - frame.ghost - sides[0] * (1.0 / 3.0)
    return 2.0 * pi * (frame.origin[0] + cells * frame.cell[0])


@inlined
def walled_volume_factor(faces, frame, number):
    """As `ring_volume_factor`, with the walls from the faces with a condition."""
    if not is_axial(frame):
        return 1.0
    return ring_volume_factor(frame, number, wall_sides(faces, frame, number))
