"""The integrals (19) and (20) along one direction, for any chi_p, by quadrature between all kinks.

The grid's shape functions and the particles' characteristic functions are products of functions of
one coordinate each, so that the integrals are products too.
"""

from typing import NamedTuple

import numpy as np

from pgimp.physics.shapes import SHAPES


class Chi(NamedTuple):
    """A characteristic function of half-width 1 and integral 1.

    Attributes
    ----------
    value : callable
        Of the distance from the centre; zero beyond 1, where it need not be right.
    kinks : tuple of float
        Where it is not a polynomial, its ends included.
    """

    value: object
    kinks: tuple


BOX = Chi(lambda s: 0.5 + 0.0 * s, (-1.0, 1.0))
TENT = Chi(lambda s: 1.0 - np.abs(s), (-1.0, 0.0, 1.0))

#: Half of Dirac's delta at each end of the box; gradients are nevertheless the box's.
ENDS = Chi(lambda s: np.nan * s, (-1.0, 1.0))

#: By the kind that a shape declares; None is Dirac's delta (34).
CHI = {"point": None, "box": BOX, "tent": TENT}

#: Exact for polynomials up to the degree 7; a tent times a tent has 2.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def chi_of(name):
    """Characteristic function of a shape, also of one with a fixed size."""
    if name in ("cpdi", "cpdi-corners"):
        return ENDS
    return CHI[SHAPES[name.removesuffix("-fixed")].chi]


def tent(r):
    """S_v of (35), r = (x - x_v)/L."""
    return np.maximum(1.0 - np.abs(r), 0.0)


def tent_slope(r):
    """L dS_v/dx; where it jumps, that to the right."""
    return np.where((r >= -1.0) & (r < 0.0), 1.0, 0.0) - np.where((r >= 0.0) & (r < 1.0), 1.0, 0.0)


def integrals(chi, half, x, xv, L):
    """S_vp (19) and dS_vp/dx (20).

    Parameters
    ----------
    chi : Chi or None
        The characteristic function.
    half, x : (n,) float
        Half-widths and coordinates of the particles.
    xv : (m,) float
        Coordinates of the vertices, `L` apart.

    Returns
    -------
    two (n, m) float64
    """
    x, half = np.atleast_1d(x)[:, None, None], np.broadcast_to(half, np.shape(x))
    half = np.atleast_1d(half)[:, None, None]
    xv = np.asarray(xv)[None, :, None]
    if chi is None:
        r = ((x - xv) / L)[..., 0]
        return tent(r), tent_slope(r) / L
    if chi is ENDS:
        low, high = (((x + sign * half - xv) / L)[..., 0] for sign in (-1.0, 1.0))
        slope = (tent(high) - tent(low)) / (2.0 * half[..., 0])
        return 0.5 * (tent(low) + tent(high)), slope
    of_chi, of_grid = x + half * np.array(chi.kinks), xv + L * np.array([-1.0, 0.0, 1.0])
    shape = np.broadcast_shapes(of_chi[..., :1].shape, of_grid[..., :1].shape)[:2]
    kinks = [np.broadcast_to(k, (*shape, k.shape[2])) for k in (of_chi, of_grid)]
    ends = np.sort(np.clip(np.concatenate(kinks, axis=2), x - half, x + half), axis=2)
    middle, reach = (ends[..., 1:] + ends[..., :-1]) / 2, (ends[..., 1:] - ends[..., :-1]) / 2
    at = middle[..., None] + reach[..., None] * NODES
    r = (at - xv[..., None]) / L
    share = reach[..., None] * WEIGHTS * chi.value((at - x[..., None]) / half[..., None])
    share = share / half[..., None]
    return (share * tent(r)).sum(axis=(2, 3)), (share * tent_slope(r) / L).sum(axis=(2, 3))
