"""exp, log, power, cbrt and tensors' functions: errors in ulp, and the same bits in every lane."""

import math

import numpy as np
import pytest
from material_driver import COMPONENTS
from reference_materials import tensor, voigt

from pgimp.jit import functions, series, spectral
from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.jit.tuples import read
from pgimp.jit.vectors.simd import lane, pack
from pgimp.kernels.transfer.lane_io import put_row, take_row

LONG = np.longdouble
pytestmark = pytest.mark.skipif(np.finfo(LONG).nmant < 63, reason="needs 80-bit floats to compare")


@kernel
def one_by_one(x, y, found):
    for k in range(len(x)):
        found[0, k] = functions.exp(x[k])
        found[1, k] = functions.log(x[k])
        found[2, k] = functions.cbrt(x[k])
        found[3, k] = functions.power(x[k], y[k])


@kernel
def together(x, y, found):
    for k in range(0, len(x), 4):
        a = pack(x[k], x[k + 1], x[k + 2], x[k + 3])
        b = pack(y[k], y[k + 1], y[k + 2], y[k + 3])
        values = math.exp(a), math.log(a), functions.cbrt(a), math.pow(a, b)
        for i in range(4):
            value = values[i]
            for j in range(4):
                found[i, k + j] = lane(value, j)


def computed(x, y=None):
    """Rows exp, log, cbrt and power, the same bits for vectors, whatever the lane."""
    y = np.ones_like(x) if y is None else y
    one, four = np.empty((4, len(x))), np.empty((4, len(x)))
    one_by_one(x, y, one)
    for shift in range(4):
        together(np.roll(x, shift), np.roll(y, shift), four)
        np.testing.assert_array_equal(np.roll(four, -shift, axis=1), one)
    return one


def ulps(found, exact):
    """Greatest error, in units of the last place of the exact value."""
    return float(np.max(np.abs(found - exact) / np.spacing(np.abs(exact.astype(float)))))


RNG = np.random.default_rng(11)
WIDE = np.exp(RNG.uniform(-700.0, 700.0, 40000))
NEAR = 1.0 + np.concatenate([s * 10.0 ** RNG.uniform(-16, -0.6, 20000) for s in (-1, 1)])
SIGNED = np.concatenate([RNG.uniform(-708.0, 709.0, 40000), RNG.uniform(-1.0, 1.0, 40000)])


def test_exp():
    assert ulps(computed(SIGNED)[0], np.exp(SIGNED.astype(LONG))) < 1.0
    edges = np.array([0.0, -0.0, 710.0, 1e300, -746.0, -1e300, math.inf, -math.inf])
    assert computed(edges)[0].tolist() == [1.0, 1.0, math.inf, math.inf, 0.0, 0.0, math.inf, 0.0]
    small = np.linspace(-745.0, -708.5, 4000)  # subnormal: to half of the smallest number
    assert np.abs(computed(small)[0] - np.exp(small.astype(LONG))).max() <= 5e-324
    assert np.isnan(computed(np.full(4, math.nan))).all()


def test_log():
    x = np.concatenate([WIDE, NEAR])
    assert ulps(computed(x)[1], np.log(x.astype(LONG))) < 1.0
    assert np.isnan(computed(np.array([0.0, -1.0, -math.inf, math.nan]))[1]).all()
    assert computed(np.ones(4))[1].tolist() == [0.0] * 4


def test_cbrt():
    x = np.concatenate([WIDE, -NEAR])
    assert ulps(computed(x)[2], np.cbrt(x.astype(LONG))) < 0.6
    cubes = np.arange(1.0, 101.0) ** 3
    assert (computed(cubes)[2] == np.arange(1.0, 101.0)).all()
    assert computed(np.zeros(4))[2].tolist() == [0.0] * 4


@pytest.mark.parametrize(("size", "most"), [(10.0, 1.0), (40.0, 2.0), (700.0, 32.0)])
def test_power(size, most):
    """Of |y ln x| up to a size."""
    x = np.concatenate([WIDE, NEAR])
    y = RNG.uniform(-size, size, len(x)) / np.maximum(np.abs(np.log(x)), 1e-3)
    exact = np.exp(y.astype(LONG) * np.log(x.astype(LONG)))
    assert ulps(computed(x, y)[3], exact) < most


def test_powers_of_zero_and_of_negative_numbers():
    x, y = np.array([0.0, 0.0, 0.0, -1.0]), np.array([0.3, 0.0, -1.0, 2.0])
    found = computed(x, y)[3]
    assert found[:3].tolist() == [0.0, 1.0, math.inf] and np.isnan(found[3])


@kernel
def of_numbers(S, found, like):
    for k in range(len(S)):
        s = read(S, k, 0, like)
        values, Q = spectral.eigen(s)
        put(found, k, (spectral.spectral(values, Q), spectral.exponential(s)), 0)
        less = series.series_expm1(s)
        put(found, k, (less, series.series_log1p(less)), 2)
        put(found, k, (spectral.logarithm(spectral.exponential(s)), less), 4)


@kernel
def of_vectors(S, found, like):
    for k in range(0, len(S), 4):
        rows = (k, k + 1, k + 2, k + 3)
        s = take_row(S, rows, 0, like)
        values, Q = spectral.eigen(s)
        less = series.series_expm1(s)
        put_row(found[0], rows, 0, spectral.spectral(values, Q))
        put_row(found[1], rows, 0, spectral.exponential(s))
        put_row(found[2], rows, 0, less)
        put_row(found[3], rows, 0, series.series_log1p(less))
        put_row(found[4], rows, 0, spectral.logarithm(spectral.exponential(s)))


@inner_kernel
def put(found, k, pair, first):
    for i in range(2):
        for j in range(len(pair[i])):
            found[first + i, k, j] = pair[i][j]


def symmetric_tensors(D, size):
    """Random ones (n, 3, 3), with eigenvalues apart, nearly equal, equal, and of small size."""
    found = []
    for spread in (1.0, 1e-4, 1e-8, 0.0):
        for scale in (1.0, 1e-3, 1e-9):
            for _ in range(20):
                Q = np.eye(3)
                Q[:D, :D] = np.linalg.qr(RNG.normal(size=(D, D)))[0]
                values = RNG.uniform(-1, 1) * np.ones(3) + spread * RNG.uniform(-1, 1, 3)
                found.append(size * scale * Q @ np.diag(values) @ Q.T)
    return np.array(found)


def exact(S, function):
    """A function of symmetric matrices by NumPy's eigenvectors."""
    w, Q = np.linalg.eigh(S)
    return np.einsum("nij,nj,nkj->nik", Q, function(w), Q)


@pytest.mark.parametrize("D", [1, 2, 3])
def test_functions_of_tensors(D):
    """Against NumPy's eigenvectors; the same bits for four particles at once."""
    for size in (0.2, 0.4, 30.0):
        matrices = symmetric_tensors(D, size)
        n = COMPONENTS[D]
        S = np.array([voigt(A, n) for A in matrices])
        like, found, four = (0.0,) * n, np.zeros((6, len(S), n)), np.zeros((6, len(S), n))
        of_numbers(S, found, like)
        of_vectors(S, four, like)
        np.testing.assert_array_equal(four[:5], found[:5])
        again, exp, expm1, log1p, log = (np.array(list(map(tensor, one))) for one in found[:5])
        norms = np.linalg.norm(matrices, axis=(1, 2))[:, None, None]
        assert (np.abs(again - matrices) <= 2e-15 * norms).all()
        right = exact(matrices, np.exp)
        largest = np.abs(right).max(axis=(1, 2))[:, None, None]
        assert (np.abs(exp - right) <= 1e-14 * (1 + size) * largest).all()
        if size > 1.0:
            continue
        assert (np.abs(log - matrices) <= 4e-15).all()
        # The series keep their digits however small the tensor is, and end early for large ones.
        most = (4e-15 if size < 0.3 else 1e-11) * norms
        assert (np.abs(expm1 - exact(matrices, np.expm1)) <= most).all()
        assert (np.abs(log1p - matrices) <= (6e-15 if size < 0.3 else 1e-9) * norms).all()


@pytest.mark.parametrize("D", [2, 3])
def test_eigenvectors_are_orthogonal_to_rounding(D):
    matrices = symmetric_tensors(D, 1e9)
    S = np.array([voigt(A, COMPONENTS[D]) for A in matrices])
    found = np.zeros((len(S), 3 + D * D))
    eigenvalues(S, found, (0.0,) * COMPONENTS[D])
    for A, row in zip(matrices, found, strict=True):
        Q = row[3:].reshape(D, D)
        np.testing.assert_allclose(Q @ Q.T, np.eye(D), atol=2e-15)
        exact = np.sort(np.linalg.eigvalsh(A))
        np.testing.assert_allclose(np.sort(row[:3]), exact, rtol=0, atol=4e-15 * abs(exact).max())


@kernel
def eigenvalues(S, found, like):
    for k in range(len(S)):
        values, Q = spectral.eigen(read(S, k, 0, like))
        for i in range(3):
            found[k, i] = values[i]
        for i in range(len(Q)):
            found[k, 3 + i] = Q[i]


@pytest.mark.parametrize("D", [1, 2, 3])
def test_carried_tensors(D):
    """(1 + A)(1 + S)(1 + A)^T - 1, without loss where both are small."""
    for scale in (0.3, 1e-9):
        S, A = symmetric_tensors(D, scale)[:20], scale * RNG.uniform(-1, 1, (20, D, D))
        rows, found = np.array([voigt(T, COMPONENTS[D]) for T in S]), np.zeros((20, COMPONENTS[D]))
        carried(A.reshape(20, -1), rows, found, (0.0,) * D**2, (0.0,) * COMPONENTS[D])
        full = np.zeros((20, 3, 3))
        full[:, :D, :D] = A
        turned = full.transpose(0, 2, 1)
        right = S + full + turned + full @ S + S @ turned + full @ turned + full @ S @ turned
        np.testing.assert_allclose(list(map(tensor, found)), right, rtol=0, atol=2e-15 * scale)


@kernel
def carried(A, S, found, matrix, symmetric):
    for k in range(len(S)):
        values = series.carry(read(A, k, 0, matrix), read(S, k, 0, symmetric))
        for i in range(len(values)):
            found[k, i] = values[i]
