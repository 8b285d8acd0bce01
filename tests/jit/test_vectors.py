"""Vectors of four particles: their functions against NumPy, materials against one at a time."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from material_driver import COMPONENTS, YOUNG, deformations, material, response, row

from pgimp.jit.algebra import determinant
from pgimp.jit.choose import choose
from pgimp.jit.kernel import allocating_kernel, inlined, kernel
from pgimp.jit.vectors.simd import (
    bits,
    halves,
    join,
    lane,
    number,
    pack,
    stack,
    store,
    vector,
    where,
)
from pgimp.kernels.transfer.lane_io import put_row, take, take_row
from pgimp.physics.materials.parameters.evaluate import evaluate, evaluate_four

ROWS = st.permutations(range(9)).map(lambda p: tuple(p[:4]))
NUMBERS = st.floats(-1e6, 1e6)
FOUR = st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS)


@allocating_kernel
def functions(a, b):
    x, y = pack(a[0], a[1], a[2], a[3]), pack(b[0], b[1], b[2], b[3])
    found = np.empty((9, 4))
    buffer = stack(4)
    for i in range(9):
        value = (
            max(x, y), min(x, 0.5), abs(x), math.floor(x), math.sqrt(abs(y)), -x,
            where(x > y, x, 1.0), x / 4.0 - 2 * y, vector(float(bits(x <= y))),
        )[i]  # fmt: skip
        store(buffer, 0, value)
        for j in range(4):
            found[i, j] = number(buffer, j)
    return found


@given(a=FOUR, b=FOUR)
@settings(max_examples=50, deadline=None)
def test_functions(a, b):
    x, y = np.array(a), np.array(b)
    expected = [
        np.maximum(x, y), np.minimum(x, 0.5), abs(x), np.floor(x), np.sqrt(abs(y)), -x,
        np.where(x > y, x, 1.0), x / 4.0 - 2.0 * y, np.full(4, np.dot(x <= y, (1, 2, 4, 8))),
    ]  # fmt: skip
    # 2 y is exact, so that a fused multiply-add rounds as the two operations do.
    np.testing.assert_array_equal(functions(a, b), expected)


@kernel
def of_eight_and_four(a, b, eight, four):
    """Results of two vectors joined, and of each: rows of eight."""
    x = pack(a[0], a[1], a[2], a[3]), pack(a[4], a[5], a[6], a[7])
    y = pack(b[0], b[1], b[2], b[3]), pack(b[4], b[5], b[6], b[7])
    found = several(join(x[0], x[1]), join(y[0], y[1]))
    low, high = several(x[0], y[0]), several(x[1], y[1])
    for i in range(len(low)):
        halfs = halves(found[i])
        for j in range(4):
            eight[i, j], eight[i, 4 + j] = lane(halfs[0], j), lane(halfs[1], j)
            four[i, j], four[i, 4 + j] = lane(low[i], j), lane(high[i], j)


@inlined
def several(x, y):
    """Results of vectors of any length."""
    return (
        max(x, y), min(x, 0.5), abs(x), math.sqrt(abs(y)), -x, where(x > y, x, 1.0),
        x / 4.0 - 3.0 * y, math.log(abs(y)), math.exp(1e-4 * x), math.pow(abs(x), 0.3),
        choose((x > 0.0) & (y > 0.0), x * y, y),
    )  # fmt: skip


@given(a=st.tuples(*[NUMBERS] * 8), b=st.tuples(*[NUMBERS] * 8))
@settings(max_examples=50, deadline=None)
def test_vectors_of_eight_are_two_of_four(a, b):
    """To the bit: each element is computed by itself."""
    eight, four = np.zeros((2, 11, 8))
    of_eight_and_four(a, b, eight, four)
    assert eight.tobytes() == four.tobytes()


@kernel
def logarithms(x, y):
    for k in range(0, len(x), 4):
        log = math.log(pack(x[k], x[k + 1], x[k + 2], x[k + 3]))
        y[k], y[k + 1], y[k + 2], y[k + 3] = lane(log, 0), lane(log, 1), lane(log, 2), lane(log, 3)


def test_log_is_right_within_an_ulp_in_every_lane():
    rng = np.random.default_rng(3)
    wide = np.exp(rng.uniform(-700.0, 700.0, 4000))
    near = 1.0 + np.concatenate([s * 10.0 ** rng.uniform(-16, -0.6, 4000) for s in (-1, 1)])
    edges = np.array(
        [1.0, np.sqrt(0.5), np.sqrt(2.0), 2.0, 0.5, 2.2250738585072014e-308, 1.7e308, 4.0]
    )
    x = np.concatenate([wide, near, edges, np.nextafter(edges[:4], 0.0)])
    y = np.empty_like(x)
    logarithms(x, y)
    exact = np.array([math.log(value) for value in x])  # itself within an ulp
    assert (np.abs(y - exact) <= 2.0 * np.spacing(np.abs(exact))).all()
    assert y[np.flatnonzero(x == 1.0)[0]] == 0.0
    none = np.empty(4)
    logarithms(np.array([0.0, -1.0, math.nan, -math.inf]), none)
    assert np.isnan(none).all()
    for shift in range(1, 4):
        z = np.empty_like(x)
        logarithms(np.roll(x, shift), z)
        assert (np.roll(z, -shift) == y).all()


@kernel
def copy_rows(source, target, rows, like):
    put_row(target, rows, 0, take_row(source, rows, 0, like))


@pytest.mark.parametrize("columns", [1, 2, 3, 4, 6, 9])
@given(rows=ROWS)
@settings(max_examples=20, deadline=None)
def test_rows_come_back(columns, rows):
    """Also at an array's end, at odd addresses, and twice the same row."""
    source = np.arange(9.0 * columns + 1)[1:].reshape(9, columns)
    for chosen in (rows, (rows[0], rows[0], 8, 8)):
        target = np.full((9, columns), -1.0)
        copy_rows(source, target, chosen, (0.0,) * columns)
        expected = np.full((9, columns), -1.0)
        expected[list(chosen)] = source[list(chosen)]
        np.testing.assert_array_equal(target, expected)


class Branching(NamedTuple):
    """A material that no vector can pass through."""

    stiffness: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        pressure = material.stiffness * (J - 1.0)
        if J > 1.0:
            pressure *= 0.5
        return pressure, pressure, pressure, 0.0

    @staticmethod
    def speed(material, F, J):
        return material.stiffness if J > 1.0 else 2.0 * material.stiffness


@kernel
def one_by_one(materials, numbers, F, sigma, stress, speed, like):
    for p in range(4):
        f = take_row(F, (p, p, p, p), 0, like)
        A = (lane(f[0], 0), lane(f[1], 0), lane(f[2], 0), lane(f[3], 0))
        J = determinant(A)
        s = (sigma[p, 0], sigma[p, 1], sigma[p, 2], sigma[p, 3])
        found = evaluate("stress", materials, numbers[p], (A, J, s, A, 1e-3), ())
        for i in range(4):
            stress[p, i] = found[i]
        speed[p] = evaluate("speed", materials, numbers[p], (A, J), ())


@kernel
def together(materials, numbers, F, sigma, stress, speed, like):
    rows = (0, 1, 2, 3)
    A = take_row(F, rows, 0, like)
    J = determinant(A)
    s = take_row(sigma, rows, 0, like)
    m = (numbers[0], numbers[1], numbers[2], numbers[3])
    put_row(stress, rows, 0, evaluate_four("stress", materials, m, (A, J, s, A, 1e-3), (), s))
    c = evaluate_four("speed", materials, m, (A, J), (), take(speed, rows))
    for j in range(4):
        speed[j] = lane(c, j)


NEO, HOOKE = material("neo-hookean"), material("hooke")


@pytest.mark.parametrize(
    "materials",
    [(NEO,), (NEO, material("neo-hookean", young=3.0)), (HOOKE, NEO), (NEO, Branching(2.0), HOOKE)],
    ids=["one", "alike", "two", "one that branches"],
)
def test_materials_of_four_are_those_of_each(materials):
    """Whatever the mix in a batch; the logarithm of vectors may differ by an ulp."""
    rng = np.random.default_rng(4)
    every = list(deformations(2, 40))
    assert COMPONENTS[2] == 4
    for k in range(0, 40, 4):
        numbers = rng.integers(0, len(materials), 4)
        F = np.array([row(A) for A in every[k : k + 4]])
        sigma = rng.normal(size=(4, 4))
        results = []
        for function in (one_by_one, together):
            stress, speed = np.zeros((4, 4)), np.zeros(4)
            function(materials, numbers, F, sigma, stress, speed, (0.0,) * 4)
            results.append((stress, speed))
        for one, four in zip(*results, strict=True):
            np.testing.assert_allclose(four, one, rtol=1e-13, atol=1e-13)


@kernel
def of_eight(materials, number, F, P, like):
    low, high = take_row(F, (0, 1, 2, 3), 0, like), take_row(F, (4, 5, 6, 7), 0, like)
    A = join(low[0], high[0]), join(low[1], high[1]), join(low[2], high[2]), join(low[3], high[3])
    J = determinant(A)
    found = evaluate_four("piola", materials, number, (A, J), (), A)
    speed = evaluate_four("speed", materials, number, (A, J), (), J)
    for i in range(2):
        rows = (4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3)
        put_row(P, rows, 0, (
            halves(found[0])[i], halves(found[1])[i], halves(found[2])[i], halves(found[3])[i],
            halves(speed)[i],
        ))  # fmt: skip


@kernel
def alone(materials, number, F, P):
    for p in range(8):
        A = (F[p, 0], F[p, 1], F[p, 2], F[p, 3])
        found = evaluate("piola", materials, number, (A, determinant(A)), ())
        for i in range(4):
            P[p, i] = found[i]
        P[p, 4] = evaluate("speed", materials, number, (A, determinant(A)), ())


class Stiffening(NamedTuple):
    """An elastic material that no vector can pass through."""

    stiffness: float

    @staticmethod
    def piola(material, F, J):
        p = material.stiffness * (J - 1.0)
        if J > 1.0:
            p *= 0.5
        return p * F[3], -p * F[2], -p * F[1], p * F[0]

    @staticmethod
    def speed(material, F, J):
        return 3.0


@pytest.mark.parametrize(
    "materials", [(NEO,), (NEO, NEO), (Stiffening(2.0), NEO)], ids=["one", "alike", "branches"]
)
def test_one_material_of_eight_is_that_of_each(materials):
    """Contraction may differ in the last place."""
    F = np.array([row(A) for A in list(deformations(2, 8))])
    for k in range(len(materials)):
        together, one = np.zeros((2, 8, 5))
        of_eight(materials, k, F, together, (0.0,) * 4)
        alone(materials, k, F, one)
        assert one.any()
        np.testing.assert_allclose(together, one, rtol=1e-13, atol=1e-13)


@kernel
def bar(materials, numbers, stretch):
    F = (pack(stretch[0], stretch[1], stretch[2], stretch[3]),)
    m = (numbers[0], numbers[1], numbers[2], numbers[3])
    zero = vector(0.0)
    sigma = evaluate_four(
        "stress", materials, m, (F, F[0], (zero, zero, zero), F, 0.0), (), (zero, zero, zero)
    )
    return lane(sigma[0], 0), lane(sigma[0], 1), lane(sigma[1], 1), lane(sigma[1], 0)


@pytest.mark.parametrize("pair", [("linear-1d", "neo-hookean"), ("neo-hookean", "linear-1d")])
def test_models_that_give_numbers_for_vectors(pair):
    """The bar's lateral stresses are 0.0 for all particles, those of others are not."""
    materials = tuple(map(material, pair))
    at = pair.index("linear-1d")
    axial, other, lateral, none = bar(
        materials, np.array([at, 1 - at, at, at]), (1.5, 1.5, 1.0, 1.0)
    )
    one = response((NEO,), np.array([[1.5]]))[0]
    assert axial == pytest.approx(0.5 * YOUNG) and none == 0.0
    assert other == pytest.approx(one[0, 0]) and lateral == pytest.approx(one[1, 1])


class Softening(NamedTuple):
    """A law with a branch, which does not take vectors."""

    bulk: float
    density: float

    @staticmethod
    def speed(material, F, J):
        if material.bulk < 4.0:
            return 0.5
        return math.sqrt(material.bulk / material.density)


@kernel
def varying_speeds(bulk, out):
    law = Softening(pack(bulk[0], bulk[1], bulk[2], bulk[3]), 2.0)
    found = evaluate_four("speed", (law,), 0, ((vector(1.0),), vector(1.0)), (), vector(0.0))
    for j in range(4):
        out[j] = lane(found, j)


def test_a_law_with_branches_varies_in_space():
    bulk, found = np.array([2.0, 8.0, 18.0, 3.0]), np.zeros(4)
    varying_speeds(bulk, found)
    assert found.tolist() == [0.5, 2.0, 3.0, 0.5]
