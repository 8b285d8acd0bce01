"""Parts of cells: the weights of bodies that are exact to their surface (`surface: exact`).

In the initial configuration a particle lies in one cell for ever, whole or cut by the surface. Its
weights are means of the cell's multilinear functions over its part. They follow from the part's
centroid and from products of inertia about it (`kernels/transfer/parts.py`). Of a whole particle
these are zero, and its weights those of points and boxes alike.
"""

from __future__ import annotations

from pgimp.physics.shapes.stretch import FixedSize


class PartParameters(FixedSize):
    """Half-widths of zero: a support begins at the cell of a part's centroid."""

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 2

    @staticmethod
    def weights(shape, half, f):
        """Tent functions of the cell's two vertices at the centroid."""
        return (1.0 - f, f), (-1.0, 1.0)

    @staticmethod
    def moments(shape, half, f, g):
        """See `pgimp.physics.shapes.base.moments`; what rings need is in their products."""
        return (0.0 * f, 0.0 * f), (0.0 * f, 0.0 * f)

    @staticmethod
    def products(dimensions, rings=False):
        """Number of a part's products of inertia: of two and of three directions, of rings."""
        return 3 if rings else (0, 1, 4)[dimensions - 1]
