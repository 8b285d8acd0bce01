"""Half-widths that follow the deformation (`physics.shapes.stretch`), and what clamps them."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pgimp.jit.kernel import kernel
from pgimp.physics.shapes.stretch import LARGEST, stretched

angles = st.floats(-np.pi, np.pi)
sizes = st.floats(0.01, 0.99)
SETTINGS = settings(max_examples=150, deadline=None)


@kernel
def call(half0, cell, F):
    return stretched(half0, cell, F)


def sized(half0, F, cell=None):
    """Half-widths in cells and whether they were clamped."""
    D = len(half0)
    cell = (1.0,) * D if cell is None else cell
    half, most = call(tuple(half0), tuple(cell), tuple(np.reshape(F, -1).tolist()))
    np.testing.assert_array_equal(np.max(half), min(most, LARGEST))
    return np.array(half), most > LARGEST


def rotation(D, angles):
    """Any rotation, from one angle in the plane and three in space."""
    R = np.eye(D)
    for axes, angle in zip(((0, 1), (1, 2), (0, 1)), angles[: 1 if D == 2 else 3], strict=False):
        turn = np.eye(D)
        i, j = axes
        turn[i, i] = turn[j, j] = np.cos(angle)
        turn[i, j], turn[j, i] = -np.sin(angle), np.sin(angle)
        R = R @ turn
    return R


@SETTINGS
@given(half=sizes, stretch=st.floats(0.01, 1.0))
def test_on_the_line_it_is_the_paper_s_finite_gimp(half, stretch):
    """Exactly l F (36-39)."""
    assert sized([half], [stretch]) == (np.array([half * stretch]), 0)


@SETTINGS
@given(D=st.sampled_from([2, 3]), half=sizes, by=st.tuples(angles, angles, angles))
def test_a_cube_that_turns_keeps_its_size(D, half, by):
    """By any angle about any axis; also after a stretch that is the same in all directions."""
    for stretch in (1.0, 0.7):
        found, clamped = sized([half] * D, stretch * rotation(D, by))
        np.testing.assert_allclose(found, half * stretch, rtol=4e-15)
        assert clamped == 0


@SETTINGS
@given(
    half=st.tuples(sizes, sizes, sizes),
    stretch=st.tuples(*[st.floats(0.05, 3.0)] * 3),
    cell=st.tuples(*[st.floats(0.1, 10.0)] * 3),
)
def test_stretches_along_the_axes(half, stretch, cell):
    """Each direction by itself, whatever the cells; from one cell on it is held and counted."""
    for D in (2, 3):
        expected = np.multiply(half, stretch)[:D]
        assume((np.abs(expected - 1.0) > 1e-12).all())
        found, clamped = sized(half[:D], np.diag(stretch[:D]), cell[:D])
        np.testing.assert_allclose(found, np.minimum(expected, 1.0), rtol=4e-15)
        assert clamped == (expected > 1.0).any()


def moments(half, F):
    """Second moments about its centre of the parallelepiped F box, by quadrature of its points."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    D = len(half)
    grid = np.stack(np.meshgrid(*[nodes] * D, indexing="ij"), axis=-1).reshape(-1, D)
    weight = np.prod(np.meshgrid(*[weights / 2] * D, indexing="ij"), axis=0).reshape(-1)
    x = (grid * half) @ F.T
    return (x * x).T @ weight


@SETTINGS
@given(
    D=st.sampled_from([2, 3]),
    half=st.tuples(*[st.floats(0.05, 0.3)] * 3),
    cell=st.tuples(*[st.floats(0.3, 3.0)] * 3),
    entries=st.tuples(*[st.floats(-0.6, 0.6)] * 9),
)
def test_any_deformation_keeps_the_second_moments(D, half, cell, entries):
    """Those of a box of half-width l are l^2/3 along each axis."""
    half, cell = np.array(half[:D]), np.array(cell[:D])
    F = np.eye(D) + np.reshape(entries[: D * D], (D, D))
    expected = np.sqrt(3.0 * moments(half * cell, F)) / cell
    assume((np.abs(expected - 1.0) > 1e-12).all())
    found, clamped = sized(half, F, cell)
    np.testing.assert_allclose(found, np.minimum(expected, 1.0), rtol=1e-13)
    assert clamped == (expected > 1.0).any()


def test_clamping_begins_above_one_cell():
    assert sized([1.0], [1.0]) == (np.array([1.0]), 0)
    half, clamped = sized([1.0], [np.nextafter(1.0, 2.0)])
    assert (half.item(), clamped) == (1.0, 1)
    half, clamped = sized([0.5, 0.5], [[1.0, 0.0], [np.sqrt(3.1), 1.0]])
    assert half.tolist() == [0.5, 1.0] and clamped == 1


def uneven(F, points=200):
    """Mean of |sum_p chi_p - 1| over a cell of a deformed lattice of unit squares."""
    half = 2.0 * sized([0.25, 0.25], F, [2.0, 2.0])[0]  # cells of 2: nothing is clamped
    along = (np.arange(points) + 0.5) / points
    x = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2) @ F.T
    total = np.zeros(len(x))
    for i in range(-3, 5):
        for j in range(-3, 5):
            total += (np.abs(x - F @ [i, j]) < half).all(axis=1)
    return np.abs(total - 1.0).mean()


@pytest.mark.parametrize("kind", ["simple shear", "pure shear", "turn"])
def test_boxes_that_cannot_tilt_are_a_partition_of_unity_to_first_order(kind):
    """As `pgimp.physics.shapes.finite_gimp` says: what overlaps and gapes grows with the square."""

    def deformed(g):
        if kind == "turn":
            return rotation(2, (g,))
        return np.array([[1.0, g], [g if kind == "pure shear" else 0.0, 1.0]])

    some, half, quarter = (uneven(deformed(g)) for g in (0.4, 0.2, 0.1))
    assert some / half > 2.8 and half / quarter > 3.4  # second order: 4
    assert uneven(np.diag([1.0, 0.7])) == 0.0
    if kind == "simple shear":  # boxes are wider by g^2/2, and centres one apart
        assert half == pytest.approx(0.2**2 / 2, rel=0.06)
