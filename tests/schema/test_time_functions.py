"""Numbers over time: values, exact integrals, series from files, and what is wrong with them."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import finish, scene, start

from pgimp.case.reader import dump_case, read_case
from pgimp.errors import CaseError
from pgimp.schema.tables import Components
from pgimp.schema.time_functions import Ramp, Series, Sine, Table

numbers = st.floats(-5.0, 5.0)
ramps = st.builds(
    lambda a, b, begin, duration: Ramp.model_validate(
        {"from": a, "to": b, "begin": begin, "duration": duration}
    ),
    numbers, numbers, numbers, st.floats(0.1, 5.0),
)  # fmt: skip
sines = st.builds(
    lambda a, f, phase, mean, begin, more: Sine.model_validate(
        {"amplitude": a, "frequency": f, "phase": phase, "mean": mean, "begin": begin}
        | ({"end": begin + more} if more else {})
    ),
    numbers, st.floats(0.05, 2.0), numbers, numbers, numbers,
    st.one_of(st.none(), st.floats(0.1, 9.0)),
)  # fmt: skip


@given(st.one_of(ramps, sines), st.floats(-6.0, 12.0))
def test_integrals_are_those_of_the_values(function, t):
    """Against Simpson's rule, whose error for these slopes is below 1e-6; kinks are of it."""
    every = np.linspace(0.0, t, 4001)
    values = np.array([function.value(float(each)) for each in every])
    weights = np.ones(4001)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    expected = (weights * values).sum() * t / 4000 / 3.0
    assert function.integral(t) == pytest.approx(expected, abs=2e-4)
    assert function.integral(0.0) == 0.0


@given(st.one_of(ramps, sines))
def test_rows_have_the_least_and_the_greatest_value(function):
    times = [time for time, _ in function.rows]
    span = np.linspace(times[0], times[min(len(times), 12) - 1], 400)
    values = [function.value(float(t)) for t in span]
    found = [value for _, value in function.rows]
    slack = 1e-9 + 1e-3 * (max(found) - min(found))
    assert min(found) <= min(values) + slack and max(found) >= max(values) - slack
    assert times == sorted(set(times))
    assert [function.value(t) for t in times] == found


def test_ends_are_held_to_the_bit():
    ramp = Ramp.model_validate({"from": 0.1, "to": 0.3, "begin": 0.2, "duration": 0.7})
    assert [ramp.value(t) for t in (-1.0, 0.2)] == [0.1, 0.1]
    assert ramp.value(0.95) == ramp.value(40.0) == pytest.approx(0.3, rel=1e-15)
    sine = Sine(amplitude=2.0, frequency=0.25, begin=1.0, end=2.0)
    assert sine.value(0.0) == 0.0 and sine.value(9.0) == sine.value(2.0) == 2.0


@pytest.mark.parametrize(("periods", "most"), [(1.0, 0.6), (3.0, 0.02), (6.0, 0.003)])
def test_a_ramp_leaves_little_of_a_vibration(periods, most):
    """What an oscillator at rest swings after a ramp of so many periods, over its deflection.

    Twice the deflection without a ramp. By Duhamel's integral, as in docs/loads-in-time.md.
    """
    omega, duration = 2.0 * math.pi, periods
    ramp = Ramp(to=1.0, duration=duration)
    every = np.linspace(0.0, duration, 20001)
    rate = np.gradient([ramp.value(float(t)) for t in every], every)
    left = abs(np.trapezoid(rate * np.exp(-1j * omega * every), every))
    assert left < most


RECORD = "# an earthquake\ntime, ax, ay\n0.0, 0.0, 9\n0.1, 1.0, 9\n\n0.3, -2.0, 9\n0.4, 0.5, 9\n"


def test_a_series_is_a_table_of_its_file(tmp_path):
    path = tmp_path / "quake.csv"
    path.write_text(RECORD)
    table = Series(file=str(path), column="ax", factor=2.0).table()
    assert table.table == ((0.0, 0.0), (0.1, 2.0), (0.3, -4.0), (0.4, 1.0))
    velocity = Series(file=str(path), column="ax", integrate=True).table()
    times = [0.0, 0.1, 0.3, 0.4]
    np.testing.assert_allclose(
        [v for _, v in velocity.table], np.cumsum([0.0, 0.05, -0.1, -0.075]), rtol=1e-14
    )
    still = Series(file=str(path), column="ax", integrate=True, baseline=True).table()
    assert still.table[-1] == (0.4, 0.0)
    drift = velocity.table[-1][1] / 0.4
    expected = [v - drift * t for t, v in velocity.table]
    np.testing.assert_allclose([v for _, v in still.table], expected, atol=1e-16)
    assert [t for t, _ in still.table] == times


def case_with(tmp_path, gravity):
    case = scene(2, {"b": {"material": "soft", "region": {"box": {"min": [1.0, 1.0],
                 "max": [2.0, 2.0]}}}}, step=0.01, end=0.4)  # fmt: skip
    case["gravity"] = gravity
    return case, str(tmp_path / "case.yaml")


def test_a_case_of_a_run_needs_no_file_any_more(tmp_path):
    """The rows are written, and read back with the same bits."""
    (tmp_path / "quake.csv").write_text(RECORD)
    series = {"file": "quake.csv", "column": "ax", "factor": 0.1}
    case, name = case_with(tmp_path, [{"series": series}, {"sine": {"amplitude": 0.1,
                           "frequency": 3.0}}])  # fmt: skip
    first = read_case(json.dumps(case), name)
    assert isinstance(first.gravity, Components)
    (tmp_path / "quake.csv").unlink()
    again = read_case(dump_case(first), name)
    assert dump_case(again) == dump_case(first) and again.gravity == first.gravity


def test_all_that_varies_is_written_as_it_is_read(tmp_path):
    """Scalars and vectors of every load, of every form."""
    sine = {"sine": {"amplitude": 0.1, "frequency": 3.0}}
    ramp = {"ramp": {"to": 0.2, "duration": 0.3}}
    case, name = case_with(tmp_path, [sine, ramp])
    region = {"box": {"min": [1.0, 1.0], "max": [1.5, 2.0]}}
    case["constraints"] = {"grip": {"body": "b", "region": region, "velocity": [sine, None]}}
    case["boundaries"] = {"y-max": {"velocity": [ramp, {"table": [[0.0, 0.0], [1.0, 0.1]]}]}}
    case["tractions"] = {
        "one": {"body": "b", "face": "x-max", "pressure": ramp},
        "two": {"body": "b", "face": "y-max", "traction": [0.0, sine]},
    }
    turns = {"about": [5.0, 5.0], "rate": sine}
    case["bodies"]["wheel"] = {
        "rigid": {"velocity": [ramp, 0.0], "rotation": turns},
        "region": {"ball": {"centre": [5.0, 5.0], "radius": 1.5}},
    }
    case["contact"] = [{"bodies": "all"}]
    first = read_case(json.dumps(case), name)
    assert read_case(dump_case(first), name) == first
    assert dump_case(read_case(dump_case(first), name)) == dump_case(first)


def test_components_over_time_give_what_a_table_of_vectors_does(tmp_path):
    """The same bits, as the same numbers are added."""
    rows = [[0.0, 0.0], [0.1, 0.3], [0.4, -0.2]]
    either = ([{"table": rows}, -0.5], {"table": [[t, [v, -0.5]] for t, v in rows]})
    one, other = (finish(start(case_with(tmp_path, gravity)[0])) for gravity in either)
    assert one.particles.v.tobytes() == other.particles.v.tobytes()
    assert np.abs(one.particles.v[:, 0]).max() > 1e-3


def test_a_body_in_free_fall_has_the_integral_of_a_sinusoidal_gravity(tmp_path):
    """Its velocity is the sum over steps: of first order in the step."""
    sine = {"amplitude": 0.4, "frequency": 2.5, "phase": 0.3}
    sim = finish(start(case_with(tmp_path, [{"sine": sine}, 0.0])[0]))
    exact = Sine(**sine).integral(sim.time)
    np.testing.assert_allclose(sim.particles.v[sim.live(), 0], exact, atol=0.01 * 0.4)


@pytest.mark.parametrize(
    ("value", "parts"),
    [
        ({"rampp": {"to": 1.0}}, ("gravity.0.rampp: unknown function of time", "ramp")),
        ({"ramp": {"from": -1e308, "to": 1e308, "duration": 1.0}}, ("gravity.0.ramp.to",)),
        ({"sine": {"amplitude": 1e308, "mean": 1e308, "frequency": 1.0}}, ("sine.amplitude",)),
        ({"sine": {"amplitude": 1.0, "frequency": 1e300}}, ("sine.frequency",)),
        ({"series": {"file": "quake.csv", "column": "ax", "factor": 1e308}}, ("too large",)),
        ({"ramp": {"to": 1.0, "duration": 0.0}}, ("gravity.0.ramp.duration",)),
        ({"sine": {"amplitude": 1.0}}, ("gravity.0.sine.frequency: missing",)),
        ({"sine": {"amplitude": 1.0, "frequency": 1.0, "end": -1.0}}, ("must end after",)),
        ({"ramp": {"to": 1.0, "duration": 1.0}, "sine": {}}, ("exactly one of",)),
        ({"series": {"file": "none.csv", "column": "ax"}}, ("gravity.0", "none.csv")),
        ({"series": {"file": "quake.csv", "column": "az"}}, ("unknown column 'az'", "ax")),
        ({"series": {"file": "quake.csv", "column": "ax", "baseline": True}}, ("integrate: true",)),
        (None, ("gravity.0: expected a number",)),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, value, parts):
    (tmp_path / "quake.csv").write_text(RECORD)
    case, name = case_with(tmp_path, [value, 0.0])
    with pytest.raises(CaseError) as error:
        read_case(json.dumps(case), name)
    assert all(part in str(error.value) for part in parts), str(error.value)


def test_a_vector_over_time_has_one_entry_a_direction(tmp_path):
    case, name = case_with(tmp_path, [{"ramp": {"to": 1.0, "duration": 1.0}}, 0.0, 0.0])
    with pytest.raises(CaseError, match="gravity: expected 2 entries") as error:
        read_case(json.dumps(case), name)
    assert len(str(error.value).splitlines()) == 1


def test_a_series_that_ends_before_the_run_is_warned_of(tmp_path, capsys):
    from pgimp.scene.checks.series import warnings

    (tmp_path / "quake.csv").write_text(RECORD)
    series = {"file": "quake.csv", "column": "ax", "integrate": True}
    case, name = case_with(tmp_path, [0.0, 0.0])
    case["time"]["end"] = 1.0
    case["boundaries"] = {"y-min": {"velocity": [{"series": series}, 0.0]}}
    (said,) = warnings(read_case(json.dumps(case), name))
    assert "boundaries.y-min.velocity.0" in said and "quake.csv ends at 0.4" in said
    case["gravity"] = [{"series": dict(series)}, 0.0]
    paths = [each.split(":")[0] for each in warnings(read_case(json.dumps(case), name))]
    assert paths == ["gravity.0", "boundaries.y-min.velocity.0"]
    case["gravity"] = [0.0, 0.0]
    series["baseline"] = True
    assert not list(warnings(read_case(json.dumps(case), name)))
    assert isinstance(read_case(json.dumps(case), name).boundaries["y-min"].velocity[0], Table)
