"""Parameters that vary in space: their values at places, and what a case may say of them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from pgimp.errors import CaseError, UsageError
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.parameters.layout import layout_of
from pgimp.physics.variation import VARIATION, NoValueError, Places
from pgimp.physics.variation.waves import lognormal, waves
from pgimp.schema.profile import read_profile

SOLID = {"model": "hooke", "young": 100.0, "poisson": 0.3, "density": 2.0}


def at(variation, x, **columns):
    """Values of a variation, as a case has it, at places."""
    x = np.atleast_2d(np.array(x, float))
    return VARIATION.validate(variation).values(Places(x, columns))


def hooke(**parts):
    return MATERIALS["hooke"].model_validate(SOLID | parts)


ROWS = [[-1.0, 3.0], [0.5, 4.0], [2.0, -1.0]]


@given(st.lists(st.floats(-1.0, 2.0), min_size=1, max_size=20))
@settings(max_examples=50, deadline=None)
def test_tables_are_linear(t):
    x = np.array([[value, 7.0] for value in t])
    expected = np.interp(t, *np.array(ROWS).T)
    np.testing.assert_allclose(at({"table": ROWS, "over": "x"}, x), expected, atol=1e-14)
    deep = np.array([[7.0, 5.0 - value] for value in t])
    found = at({"table": ROWS, "over": "depth", "surface": 5.0}, deep)
    np.testing.assert_allclose(found, expected, atol=1e-14)


def test_rows_of_tables_are_met_exactly():
    x = np.array([[row[0]] for row in ROWS])
    assert at({"table": ROWS, "over": "x"}, x).tolist() == [row[1] for row in ROWS]
    assert at({"table": [[1.0, 0.1]], "over": "x"}, [[1.0]]).tolist() == [0.1]


def test_beyond_the_ends_of_a_table():
    with pytest.raises(NoValueError, match=r"lies at x 2\.1, where the table, from -1 to 2,"):
        at({"table": ROWS, "over": "x"}, [[0.0], [2.1]])
    found = at({"table": ROWS, "over": "x", "beyond": "hold"}, [[-3.0], [9.0]])
    assert found.tolist() == [3.0, -1.0]
    # What rounding may do to a place at an end.
    assert at({"table": ROWS, "over": "x"}, [[2.0 + 1e-12]]).tolist() == [-1.0]


def test_layers_begin_where_they_say():
    layers = {"layers": [[0.0, 1.0], [2.0, 5.0], [3.0, 2.0]], "over": "y"}
    x = [[9.0, y] for y in (0.0, 1.9, 2.0, 2.9, 3.0, 99.0)]
    assert at(layers, x).tolist() == [1.0, 1.0, 5.0, 5.0, 2.0, 2.0]
    with pytest.raises(NoValueError, match=r"at y -0\.5, before the first layer"):
        at(layers, [[0.0, -0.5]])


def test_columns_and_products():
    young = np.array([1.0, 2.0, 4.0])
    x = [[0.0], [1.0], [2.0]]
    assert at({"column": "e", "times": 3.0}, x, e=young).tolist() == [3.0, 6.0, 12.0]
    trend = {"table": [[0.0, 1.0], [2.0, 3.0]], "over": "x"}
    assert at({"column": "e", "times": trend}, x, e=young).tolist() == [1.0, 4.0, 12.0]


@pytest.mark.parametrize("kind", ["exponential", "gaussian"])
def test_fields_are_sums_of_waves(kind):
    found = waves(kind, (2.0, 0.5), 7, 50)
    x = np.random.default_rng(3).uniform(-40.0, 40.0, (200, 2))
    t = x @ found.vectors.T + found.phases
    expected = math.sqrt(2.0 / 50) * np.cos(2.0 * np.pi * (t - np.floor(t))).sum(axis=1)
    # 50 waves, each of whose angles is known to an ulp of up to a thousand turns.
    np.testing.assert_allclose(found.at(x), expected, atol=1e-10)
    # One by one, in any order: the same bits.
    alone = np.concatenate([found.at(x[i : i + 1]) for i in range(50)])
    assert np.array_equal(alone, found.at(x)[:50])
    assert np.array_equal(found.at(x[::-1]), found.at(x)[::-1])


SEEDS, APART, NEAR = 1500, 20, np.array([0.0, 0.25, 0.5, 1.0, 2.0])


@pytest.mark.parametrize(
    ("kind", "covariance"),
    [("exponential", lambda r: np.exp(-r)), ("gaussian", lambda r: np.exp(-r * r))],
)
def test_statistics_of_fields(kind, covariance):
    """Mean, variance and covariance over all seeds, along either direction.

    The 30,000 pairs of each distance are independent, but for 1/sqrt(2 M) of each field of M waves:
    standard errors are below sqrt(2/30000) + 1/sqrt(2 64 1500) = 0.0104, taken four times.
    """
    lengths = (3.0, 0.7)
    far = 60.0 * np.arange(APART)[:, None] * np.array(lengths)
    x = [far + r * step for step in np.diag(lengths) for r in NEAR]
    sums = np.zeros((2, len(NEAR)))
    first = np.zeros(2)
    for seed in range(SEEDS):
        g = waves.__wrapped__(kind, lengths, seed, 64).at(np.concatenate(x))
        g = g.reshape(2, len(NEAR), APART)
        sums += (g * g[:, :1]).mean(axis=2) / SEEDS
        first += (g[0, 0].mean() / SEEDS, (g[0, 0] ** 2).mean() / SEEDS)
    assert abs(first[0]) < 0.03
    assert abs(first[1] - 1.0) < 0.045
    np.testing.assert_allclose(sums, np.tile(covariance(NEAR), (2, 1)), atol=0.045)


def test_mean_and_scatter_of_distributions():
    g = np.random.default_rng(5).normal(size=200_000)
    values = lognormal(g, -4.0, 0.5)
    assert values.max() < 0.0
    assert values.mean() == pytest.approx(-4.0, rel=0.01)
    assert values.std() == pytest.approx(2.0, rel=0.02)
    statistics = {"mean": 5.0, "deviation": 2.0, "distribution": "normal", "correlation": 1.0}
    x = np.random.default_rng(6).uniform(0.0, 1000.0, (4000, 2))
    found = at({"random": statistics}, x)
    # Of 4000 places, and of some 1000 waves.
    assert found.mean() == pytest.approx(5.0, abs=0.15)
    assert found.std() == pytest.approx(2.0, rel=0.06)
    limited = at({"random": statistics, "between": [4.0, 5.5]}, x)
    assert np.array_equal(limited, np.clip(found, 4.0, 5.5))


def test_a_material_at_a_place_is_one_of_numbers():
    graded = hooke(young={"table": [[0.0, 10.0], [4.0, 30.0]], "over": "x"})
    assert graded.at((1.0, 9.0)) == hooke(young=15.0)
    assert graded.model_dump()["young"]["table"] == ((0.0, 10.0), (4.0, 30.0))
    with pytest.raises(UsageError, match="young: the place lies at x 5"):
        graded.at((5.0,))
    with pytest.raises(UsageError, match="young is the column e of particles"):
        hooke(young={"column": "e"}).at((0.0,))


def test_particles_carry_what_depends_on_what_varies():
    def layout(entry):
        return layout_of(entry, lambda one: one.parameters())

    found = layout(hooke(young={"column": "e"}))
    assert (found.varying, found.indices, found.width) == ([0, 1], [2], 3)
    found = layout(hooke(density={"column": "rho"}))
    assert (found.varying, found.indices, found.width) == ([2], [0], 1)  # the density itself
    metal = SOLID | {"model": "von-mises", "yield-stress": 1.0}
    metal |= {"saturation": {"stress": {"column": "q"}, "rate": 2.0}}
    found = layout(MATERIALS["von-mises"].model_validate(metal))
    assert found.paths == [("saturation", "stress")]
    assert [found.base._fields[i] for i in found.varying] == ["saturation"]


WRONG = [
    ({"young": {"tabel": []}}, "young",
     "one of table, layers, random, column, function; got a mapping with the keys tabel"),
    ({"young": {"table": [], "over": "x"}}, "young.table", "expected at least one row"),
    ({"young": {"table": [[0.0, 1.0], [0.0, 2.0]], "over": "x"}}, "young.table.1.0",
     "must increase, but 0.0 follows 0.0"),
    ({"young": {"table": [[0.0, 1.0], [1.0, -2.0]], "over": "x"}}, "young.table.1.1",
     "must be above 0, got -2"),
    ({"young": {"layers": [[0.0, 1.0], [1.0, 0.0]], "over": "x"}}, "young.layers.1.1",
     "must be above 0, got 0"),
    ({"young": {"table": [[0.0, 1.0]]}}, "young.over", "missing"),
    ({"young": {"table": [[0.0, 1.0]], "over": "depth"}}, "young.surface", "missing"),
    ({"young": {"table": [[0.0, 1.0]], "over": "x", "surface": 1.0}}, "young.surface",
     "belongs to over: depth"),
    ({"young": {"random": {"mean": 1.0, "correlation": 1.0}}}, "young.random", "cov and deviation"),
    ({"young": {"random": {"mean": -1.0, "cov": 0.1, "correlation": 1.0}}}, "young", "above 0"),
    ({"young": {"column": "E"}}, "young.column", "a name starts with"),
    ({"young": {"column": "e", "times": {"colum": "f"}}}, "young.times", "one of table"),
    ({"poisson": {"layers": [[0.0, 0.3], [1.0, 0.5]], "over": "x"}}, "poisson.layers.1.1",
     "must be below 0.5"),
    ({"viscosity": {"linear": {"column": "a"}, "quadratic": 0.0}}, "viscosity.linear",
     "artificial viscosity is the same everywhere"),
]  # fmt: skip


@pytest.mark.parametrize(("parts", "path", "text"), WRONG)
def test_what_is_wrong_is_said_where_it_is(parts, path, text):
    with pytest.raises(ValidationError) as raised:
        hooke(**parts)
    found = [(".".join(map(str, e["loc"])), e["msg"]) for e in raised.value.errors()]
    assert [where for where, _ in found] == [path]
    assert text in found[0][1]


PROFILE = "depth, cohesion ,young\n# from a borehole\n0.0,10.0,1e6\n\n5.0,20.0,4e6\n"


def test_a_profile_from_a_file(tmp_path):
    path = tmp_path / "soil.csv"
    path.write_text(PROFILE)
    assert read_profile(path, "depth", "young") == ((0.0, 1e6), (5.0, 4e6))
    for text, message in (
        (PROFILE.replace("5.0,", "0.0,"), "line 5, column depth: the coordinates must increase"),
        (PROFILE.replace("4e6", "many"), "line 5, column young: 'many' is no number"),
        (PROFILE.replace("4e6", "4_000"), "line 5, column young: '4_000' is no number"),
        (PROFILE.replace("4e6", "4e6,1"), "line 5: 4 values, expected 3"),
        (PROFILE.replace("depth", "z"), "line 1: unknown column 'depth'"),
        ("", "has no row of numbers"),
    ):
        path.write_text(text)
        with pytest.raises(CaseError, match=message):
            read_profile(path, "depth", "young")
    with pytest.raises(CaseError, match="cannot read the table"):
        read_profile(tmp_path / "none.csv", "depth", "young")
