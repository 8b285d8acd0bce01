"""The measures of a study: errors, orders, limits, fronts, and the axes that show them."""

import re
from itertools import pairwise
from math import isclose
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from study_files import HEAD, SWEEP

from pgimp.errors import CaseError
from pgimp.utilities.plot.style import STYLE
from pgimp.utilities.study.limits import limit
from pgimp.utilities.study.measure_entry import Measure
from pgimp.utilities.study.measures import MeasureError, measure, orders, pareto
from pgimp.utilities.study.plan import read_plan
from pgimp.utilities.study.plot import _guides
from pgimp.utilities.study.tables import verdict


def test_a_measure_is_a_line_of_a_column():
    history = np.zeros(5, dtype=[("time", float), ("a", float), ("b", float)])
    history["time"] = [0.0, 0.1 + 0.2, 0.6, 0.9, 1.2]
    history["a"] = [5.0, -9.0, 4.0, 7.0, 3.0]
    history["b"] = [0.0, np.nan, 1.0, 1.0, np.inf]

    def value(**wanted):
        return measure(history, Measure.model_validate({"column": "a", **wanted}))

    assert value() == 3.0
    assert value(at="max") == 9.0
    assert value(at=0.3) == 9.0  # 0.1 + 0.2 is a rounding error later
    assert value(at=0.61) == 7.0
    assert value(at=0) == 5.0
    assert value(at={"mean": [0.6, 1.2]}) == pytest.approx((4.0 + 7.0) / 4 + (7.0 + 3.0) / 4)
    assert value(at={"mean": [0.75, 0.9]}, reference=1.0) == pytest.approx((5.5 + 7.0) / 2 - 1.0)
    assert value(reference=4.0) == 1.0
    assert value(reference=-8.0, relative=True, at="max") == 15.0 / 8.0
    for wanted, why in (
        ({"column": "c"}, "unknown column 'c'"),
        ({"at": 1.3}, "ends before t = 1.3, at 1.2"),
        ({"at": {"mean": [0.5, 1.3]}}, "ends before t = 1.3, at 1.2"),
        ({"column": "b"}, "b is inf"),
        ({"column": "b", "at": "max"}, "b@max is nan"),
    ):
        with pytest.raises(MeasureError, match=re.escape(why)):
            value(**wanted)
    with pytest.raises(MeasureError, match="no lines"):
        measure(history[:0], Measure(column="a"))


@given(
    st.lists(st.floats(1e-3, 1e3), min_size=2, max_size=6, unique=True),
    st.floats(-1.0, 4.0),
    st.floats(1e-6, 1e3),
    st.randoms(),
)
def test_a_power_of_the_cell_has_its_order(cells, order, factor, random):
    cells.sort(reverse=True)
    if any(a / b < 1.01 for a, b in pairwise(cells)):
        return
    points = [(x, factor * x**order) for x in cells]
    random.shuffle(points)
    found = dict(zip([x for x, _ in points], orders(points), strict=True))
    assert found.pop(cells[0]) is None
    # Rounding of a part in 1e15 each, over a ratio of cells of at least 1.01.
    assert all(isclose(value, order, abs_tol=1e-12) for value in found.values())


def test_orders_skip_what_has_none():
    assert orders([(1.0, 4.0), (0.5, 0.0), (0.25, 0.25), (0.25, 0.1), (-1.0, 1.0)]) == [
        None, None, 2.0, None, None,
    ]  # fmt: skip
    assert orders([]) == []


numbers = st.integers(0, 6).map(float) | st.floats(0.0, 1e9)


@given(st.lists(st.tuples(numbers, numbers), max_size=25))
def test_the_pareto_front_is_that_of_brute_force(points):
    def beats(p, q):
        return p[0] <= q[0] and p[1] <= q[1] and p != q

    front = pareto(points)
    assert set(front) == {i for i, p in enumerate(points) if not any(beats(q, p) for q in points)}
    assert [points[i][0] for i in front] == sorted(points[i][0] for i in front)
    assert len(front) == len(set(front))


@pytest.mark.parametrize(
    ("xs", "errors"),
    [
        ((5.0, 2.5, 1.0, 0.5), (2e-2, 1e-2, 3e-3, 8e-4)),
        ((0.05, 0.02, 0.01), (0.3, 0.3, 0.299)),  # beside a flat curve both orders soon leave
        ((4.0, 2.0), (1e-9, 1.0)),
        ((100.0, 0.01), (1.0, 1e-12)),
        ((2.0, 1.9), (0.5, 0.45)),
    ],
)
def test_labels_of_orders_stay_inside_their_panel(xs, errors):
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    points = zip(xs, errors, strict=True)
    runs = [SimpleNamespace(plan=SimpleNamespace(x=x), error=error) for x, error in points]
    with rc_context(STYLE):
        figure = Figure(figsize=(4.2, 4.2))
        canvas = FigureCanvasAgg(figure)
        axis = figure.subplots()
        axis.loglog(xs, errors, "o-")
        _guides(axis, runs)
        canvas.draw()
    frame = axis.get_window_extent()
    for text in axis.texts:
        box = text.get_window_extent()
        assert frame.x0 <= box.x0 and box.x1 <= frame.x1
        assert frame.y0 <= box.y0 and box.y1 <= frame.y1
    assert [text.get_text() for text in axis.texts] == ["order 1", "order 2"]


@given(
    value=st.floats(-100.0, 100.0),
    error=st.floats(0.01, 10.0),
    order=st.floats(0.6, 2.4),
    ratios=st.tuples(st.floats(1.2, 4.0), st.floats(1.2, 4.0)),
    sign=st.sampled_from([-1.0, 1.0]),
)
def test_a_power_of_the_cell_has_its_limit(value, error, order, ratios, sign):
    """From any three sizes; from two if the order is 1."""
    x = [0.3, 0.3 / ratios[0], 0.3 / ratios[0] / ratios[1]]
    found = limit([(h, value + sign * error * h**order) for h in x])
    assert found is not None and found.order is not None
    # What rounding of the values makes of the order.
    assert found.order == pytest.approx(order, abs=1e-4)
    assert found.value == pytest.approx(value, abs=1e-4 * error)
    both = limit([(h, value + sign * error * h) for h in x[:2]])
    assert both is not None and both.order is None
    assert both.value == pytest.approx(value, abs=1e-9)


def test_values_that_tell_no_order_are_taken_for_first_order():
    """Those that swing, and those that come closer faster than any method here does."""
    for values in ((1.0, 3.0, 2.0), (1.0 + 2.0**-3, 1.0 + 4.0**-3, 1.0 + 8.0**-3)):
        points = list(zip((0.5, 0.25, 0.125), values, strict=True))
        found, two = limit(points), limit(points[1:])
        assert found is not None and two is not None
        assert found.order is None and found.value == two.value
    assert limit([(0.1, 3.0)]) is None and limit([(0.1, 3.0), (0.1, 2.0), (0.0, 1.0)]) is None


def test_only_the_error_has_a_limit(tmp_path):
    wanted = "columns: [{column: mass, reference: limit}]\n"
    (tmp_path / "s.yaml").write_text(HEAD + SWEEP + wanted)
    with pytest.raises(CaseError, match=r"s\.yaml:6: columns\.0\.reference: only the error"):
        read_plan(tmp_path / "s.yaml")


def test_runs_without_a_difference_have_no_error():
    """As the strain energy of what still falls: 0 on all cells."""
    plan = SimpleNamespace(study=SimpleNamespace(measure=SimpleNamespace(label="a", relative=True)))
    runs = [SimpleNamespace(value=0.0, error=None) for _ in range(3)]
    said = verdict(plan, runs, limit([(0.4, 0.0), (0.2, 0.0), (0.1, 0.0)]))
    assert said.startswith("a is 0 in all runs, which says nothing") and "later time.end" in said
