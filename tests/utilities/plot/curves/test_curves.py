"""``pgimp plot``: curves of the history and of probes are what their files hold."""

import shutil
from itertools import pairwise

import numpy as np
import pytest
from plotted import history, invented, numbers, table
from scenes import SOFT, box, scene

import pgimp
from pgimp.mpi.comm import Serial
from pgimp.utilities.plot.runs import open_runs
from pgimp.utilities.plot.style import log_ticks

RUNS = ("bar", "plates", "other")


def test_history_of_two_runs(runs, plot, tmp_path):
    columns = "kinetic-energy,body.low.centre-y"
    status, said, _ = plot("plates.out", "other.out", "--columns", columns, "--csv", "drawn.csv")
    assert status == 0
    assert "wrote plates-other-history.png and drawn.csv" in said
    drawn = table(tmp_path / "drawn.csv")
    assert list(drawn) == ["run", "time", "kinetic-energy", "body.low.centre-y"]
    for name in ("plates", "other"):
        mine = np.array(drawn["run"]) == name
        there = history(runs, f"{name}.out")
        assert mine.sum() == len(there) > 5
        for column in list(drawn)[1:]:
            np.testing.assert_array_equal(numbers(drawn, column)[mine], there[column])


def test_history_columns_by_default_and_by_pattern(plot, tmp_path):
    assert plot("plates.out", "--csv", "a.csv")[0] == 0
    there = list(table(tmp_path / "a.csv"))
    assert there[:4] == ["run", "time", "kinetic-energy", "strain-energy"]
    assert "external-work" in there
    assert plot("plates.out", "--columns", "body.*.centre-?", "--x", "step", "-o", "b.csv")[0] == 0
    centres = [f"body.{body}.centre-{axis}" for body in ("low", "high") for axis in "xy"]
    assert list(table(tmp_path / "b.csv")) == ["run", "step", *centres]


def test_plastic_work_is_among_the_energies_by_default(plot, tmp_path):
    metal = {"soft": SOFT | {"model": "von-mises", "yield-stress": 1.0}}
    case = scene(
        1, box([0.0], [5.0], [-1.0]), materials=metal, boundaries={"x-min": "fixed"},
        history={"every": {"steps": 10}},
    )  # fmt: skip
    run = pgimp.run(case, Serial(), tmp_path / "flows.out", quiet=True)
    assert run.history["plastic-work"][-1] > 0.0
    assert plot("flows.out", "--csv", "a.csv")[0] == 0
    assert "plastic-work" in table(tmp_path / "a.csv")


def drawn_and_files(runs, plot, tmp_path, *words):
    """The table of a figure of bar.out, its columns, the history and the probes, all by step."""
    status, said, _ = plot("bar.out", *words, "-o", "a.csv")
    assert status == 0
    names = ("history", "probes/tip", "probes/slow")
    files = [
        np.genfromtxt(runs / "bar.out" / f"{name}.csv", delimiter=",", names=True, deletechars="")
        for name in names
    ]
    return table(tmp_path / "a.csv"), files, said


def test_probes_beside_the_history(runs, plot, tmp_path):
    words = ("--probe", "tip", "--columns", "displacement-x,strain-energy")
    drawn, (history, tip, _), said = drawn_and_files(runs, plot, tmp_path, *words)
    assert list(drawn) == ["run", "probe", "time", "displacement-x", "strain-energy"]
    assert set(drawn["probe"]) == {"tip"}
    assert len(history) > 4 and tip["displacement-x"].max() > 0.0
    np.testing.assert_array_equal(numbers(drawn, "displacement-x"), tip["displacement-x"])
    np.testing.assert_array_equal(numbers(drawn, "strain-energy"), history["strain-energy"])
    assert "left out" not in said

    words = ("--probe", "slow", "--x", "displacement.grip-x", "--y", "displacement-x")
    drawn, (history, _, slow), said = drawn_and_files(runs, plot, tmp_path, *words)
    both = sorted({*history["step"]} & {*slow["step"]})
    assert 2 <= len(both) < min(len(history), len(slow))
    for name, file in (("displacement.grip-x", history), ("displacement-x", slow)):
        values = [file[name][list(file["step"]).index(step)] for step in both]
        np.testing.assert_array_equal(numbers(drawn, name), values)
    assert f"{max(len(history), len(slow)) - len(both)} lines left out" in said

    words = ("--probe", "tip,slow", "--columns", "velocity-*")
    drawn, (_, tip, slow), _ = drawn_and_files(runs, plot, tmp_path, *words)
    expected = np.concatenate([tip["velocity-x"], slow["velocity-x"]])
    np.testing.assert_array_equal(numbers(drawn, "velocity-x"), expected)
    assert drawn["probe"] == ("tip",) * len(tip) + ("slow",) * len(slow)
    assert plot("bar.out", "--probe", "tip,slow")[0] == 0
    assert (tmp_path / "bar-tip-slow.png").exists()
    assert plot("bar.out", "--probe", "place")[0] == 0


def test_force_against_displacement_in_one_command(runs, plot, tmp_path):
    words = ("--x", "displacement.grip-x", "--y", "constraint.grip-x")
    drawn, (history, *_), _ = drawn_and_files(runs, plot, tmp_path, *words)
    assert list(drawn) == ["run", "displacement.grip-x", "constraint.grip-x"]
    t = history["time"]
    up, down = np.minimum(t, 0.06), np.maximum(t - 0.06, 0.0)
    way = 2.5 * up**2 + 0.3 * down - 3.75 * down**2
    np.testing.assert_allclose(numbers(drawn, "displacement.grip-x"), way, rtol=1e-12, atol=1e-17)
    assert np.abs(numbers(drawn, "constraint.grip-x")).max() > 0.0


def test_the_greatest_component_of_each_force_by_default(runs, plot, tmp_path):
    """Of all runs together; signs do not matter, nor lines without a value."""
    names = [f"{name}-{axis}" for name in ("reaction.y-min", "constraint.a") for axis in "xy"]
    none = [0.0] * 3
    for run, values in {
        "one": ([0, 5, 1], [0, 2, 3], none, [0, "nan", -3]),
        "two": ([0, -8, 0], [7, 0, 0], [0, 2, 0], none),
    }.items():
        forces = dict(zip(names, values, strict=True)) | {"reaction.x-min-x": none}
        invented(runs, tmp_path, run, **{"kinetic-energy": none}, **forces)
    assert plot("one.out", "two.out", "--csv", "a.csv")[0] == 0
    expected = ["run", "time", "kinetic-energy", "reaction.y-min-x", "constraint.a-y"]
    assert list(table(tmp_path / "a.csv")) == expected


def drawn_texts(figure):
    """What is written into the panels of a figure, and how many points its lines show."""
    axes = [axis for axis in figure.axes if axis.get_visible()]
    marked = [line for axis in axes for line in axis.lines if line.get_marker() != "None"]
    return [text.get_text() for axis in axes for text in axis.texts], marked


def test_single_lines_and_columns_without_a_value(runs, tmp_path):
    """A single line is a point, which a curve alone would not show."""
    from pgimp.utilities.plot.curves.curves import curves

    nothing = ["nan"] * 3
    invented(runs, tmp_path, "a", **{"mass": [1, 2, 3], "body.low.centre-x": nothing})
    shown = open_runs([str(tmp_path / "a.out")])
    for logarithmic, text in ((False, "no value"), (True, "no positive value")):
        figure, _, _ = curves(shown, [], ["mass", "body.low.centre-x"], "time", logarithmic)
        assert drawn_texts(figure)[0] == [text]
    one = tmp_path / "a.out" / "history.csv"
    one.write_text("".join(one.read_text().splitlines(keepends=True)[:2]))
    figure, _, _ = curves(open_runs([str(tmp_path / "a.out")]), [], ["mass"], "time", False)
    texts, marked = drawn_texts(figure)
    assert texts == [] and len(marked) == 1


def test_runs_in_different_units_are_noted(plot):
    status, said, _ = plot("bar.out", "plates.out", "--columns", "mass")
    assert status == 0
    assert "note: the runs have different units; those shown are of bar.out" in said


def test_names_may_have_dollars(runs, plot, tmp_path):
    """They would be read as mathematics, which this is not."""
    shutil.copytree(runs / "plates.out", tmp_path / r"a$\x_$.out")
    for words in ((), ("--field", "body"), ("--along", "x")):
        assert plot("other.out", r"a$\x_$.out", *words, "-o", "a.png")[0] == 0


@pytest.mark.parametrize("low", [1.0, 1.3e-9, 4.7e5])
@pytest.mark.parametrize("over", [1.02, 1.5, 4.0, 30.0, 1e3, 1e7])
def test_logarithmic_axes_have_labels_apart_from_each_other(low, over):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.0, 2.5))
    canvas = FigureCanvasAgg(figure)
    axis = figure.subplots()
    axis.set_yscale("log")
    axis.set_ylim(low, over * low)
    log_ticks(axis.yaxis)
    canvas.draw()
    boxes = [
        tick.label1.get_window_extent()
        for tick in axis.yaxis.get_major_ticks() + axis.yaxis.get_minor_ticks()
        if low <= tick.get_loc() <= over * low and tick.label1.get_text()
    ]
    boxes.sort(key=lambda one: one.y0)
    assert len(boxes) >= 2
    assert all(one.y1 < two.y0 for one, two in pairwise(boxes))
