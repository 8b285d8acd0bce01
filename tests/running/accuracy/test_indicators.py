"""Indicators of accuracy: books that close, stripes and gradients, bounds, the line of a run."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from pages import DOCS
from scenes import SOFT, box, scene
from two_blocks import CASE, flying

import pgimp
from pgimp.case.load import load
from pgimp.running.accuracy.books import energy_book, momentum_books
from pgimp.running.accuracy.find import boxes_of, of_case, of_frames, of_history, of_run
from pgimp.running.accuracy.particles import body_states
from pgimp.running.accuracy.rules import RULES, Indicator, line


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("accuracy")
    (folder / "blocks.yaml").write_text(CASE)
    return pgimp.run(folder / "blocks.yaml", output=folder / "blocks.out", quiet=True)


def test_the_book_of_energy_closes(run):
    book = energy_book(np.asarray(run.history))
    given, stored, taken = (sum(e.values for e in part) for part in book[:3])
    np.testing.assert_allclose(given, stored + taken, rtol=1e-12)
    assert book.scale >= given[0] > 0.0
    assert energy_book(np.asarray(run.history)[:0]) is None


@pytest.mark.parametrize(("growth", "least", "most"), [(0.0, 0.0, 0.01), (0.01, 0.15, 0.25)])
def test_velocities_half_a_step_behind_are_no_energy_from_nothing(growth, least, most):
    """An oscillator in ten steps a radian: its energy is right to dt^2, as read off to dt/2."""
    dt, x, v, lines = 0.1, 1.0, 0.0, []
    for n in range(200):
        v -= dt * x
        x += dt * v
        kinetic, strain = 0.5 * v * v, 0.5 * x * x
        kinetic, strain = (e * np.exp(growth * n * dt) for e in (kinetic, strain))
        lines.append((n * dt, dt, kinetic, strain, 0.0, 0.5 - kinetic - strain))
    names = "time dt kinetic-energy strain-energy external-work dissipated-energy"
    book = energy_book(np.array(lines, [(name, float) for name in names.split()]))
    assert least <= book.gained < most
    assert -book.lost.min() > 0.04


def test_the_book_of_momentum_closes_to_rounding(run):
    """The left block loses nothing to walls before it meets the other; all forces are known."""
    books, why = momentum_books(run.case, np.asarray(run.history))
    assert [book.axis for book in books] == ["x", "y"] and not why
    for book in books:
        assert abs(book.rest) < 1e-11 * book.scale
    tractions = load(flying(tractions={"a": {"body": "a", "face": "x-max", "pressure": 1.0}}))
    assert momentum_books(tractions, np.asarray(run.history))[0] == []


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize(
    ("region", "cells", "within"),
    [
        # A plate across the main diagonal, of 0.2 in cells of 0.1.
        (lambda n: {"intersection": [
            {"box": {"min": [0.5] * n, "max": [3.5] * n}},
            *({"half-space": {"point": [2.0 + s * 0.1 / n**0.5] * n, "normal": [s] * n}}
              for s in (1.0, -1.0)),
        ]}, 2.0, 0.06),
        # A ring or a shell of 0.3.
        (lambda n: {"difference": [
            {"ball": {"centre": [2.0] * n, "radius": 1.5}},
            {"ball": {"centre": [2.0] * n, "radius": 1.2}},
        ]}, 3.0, 0.1),
        # A quarter of it, on planes of symmetry.
        (lambda n: {"intersection": [
            {"difference": [
                {"ball": {"centre": [0.0] * n, "radius": 3.5}},
                {"ball": {"centre": [0.0] * n, "radius": 2.9}},
            ]},
            {"box": {"min": [0.0] * n, "max": [4.0] * n}},
        ]}, 6.0, 0.1),
    ],
)  # fmt: skip
def test_cells_across_bodies_that_lie_in_any_direction(dimensions, region, cells, within):
    """Boxes around them are wider by far; chords are longer than the thickness by their angle."""
    data = scene(dimensions, {"body": {"material": "soft", "region": region(dimensions)}},
                 grid={"size": [4.0] * dimensions, "cell": [0.1] * dimensions},
                 boundaries={f"{axis}-min": "slip" for axis in "xyz"[:dimensions]})  # fmt: skip
    case = pgimp.load(data)
    (found,) = (one.value for one in of_case(case, boxes_of(case)) if one.name == "cells")
    assert cells * (1.0 - 1e-3) - 0.05 <= found <= cells * (1.0 + within)


def test_a_run_ends_with_what_is_uncomfortable(run):
    """Two blocks of three cells that stick together; nothing is said where all is well."""
    (said,) = re.findall("^accuracy: (.*)", (run.path / "log.txt").read_text(), re.MULTILINE)
    assert said == line(of_run(run)) and "cells across 'left' 3 (well from 8)" in said
    timings = json.loads((run.path / "run.json").read_text())["starts"][-1]["timings"]
    assert all(len(seconds) == 1 for seconds in timings.values()) and "P2G" in timings
    well = [Indicator("lost", 0.02), Indicator("cells", 8.0, "left")]
    assert line(well) == "" and line([]) == ""


def test_inertia_counts_where_it_is_scaled(run):
    """Kinetic over strain energy at the end; without mass scaling a case is meant to move."""
    history = np.asarray(run.history)
    time = run.case.time.model_copy(update={"mass_scaling": 100.0})
    scaled = run.case.model_copy(update={"time": time})
    (one,) = [each for each in of_history(scaled, history) if each.name == "inertia"]
    last = history[-1]
    assert one.value == pytest.approx(last["kinetic-energy"] / last["strain-energy"])
    assert one.well == (one.value <= 0.02)
    assert all(each.name != "inertia" for each in of_history(run.case, history))


def test_the_worst_is_named_first_and_of_a_kind_only_once():
    found = [Indicator("cells", 4.0, "a"), Indicator("cells", 2.0, "b"), Indicator("lost", 0.06)]
    said = line(found)
    assert said.index("'b'") < said.index("lost") and "'a'" not in said
    assert said.endswith(": docs/" + RULES["cells"].page)
    assert Indicator("cells", 0.0).distance == np.inf


def test_a_value_that_rounds_to_its_bound_has_more_digits():
    """Not "mass past walls 0.1 % (well up to 0.1 %)"."""
    assert Indicator("walls", 1.004e-3).text == "mass past walls 0.1004 % (well up to 0.1 %)"
    assert (
        Indicator("lost", 0.0501).text
        == "energy lost by the method 5.01 % of the greatest energy in the run (well up to 5 %)"
    )
    assert (
        Indicator("lost", 0.05).text
        == "energy lost by the method 5 % of the greatest energy in the run (well up to 5 %)"
    )
    assert "stretch of boxes 1.5004 (" in Indicator("stretch", 1.5004).text


class Made:
    """A frame of squares in a block of cells, with a stress of one component."""

    bodies = ("body",)
    path = "made"

    def __init__(self, stress, **fields):
        place = np.stack(np.meshgrid(*[np.arange(16) / 2 + 0.25] * 2, indexing="ij"), axis=-1)
        x = np.zeros((256, 3))
        x[:, :2] = place.reshape(-1, 2)
        full = np.zeros((256, 6))
        full[:, 0] = stress(*x[:, :2].T)
        constant = {"body": np.zeros(256, int), "volume": np.full(256, 0.25)}
        self.fields = constant | {"position": x, "stress": full} | fields

    def __len__(self):
        return 256

    def __contains__(self, name):
        return name in self.fields

    def rows(self, name, first, last):
        return self.fields[name][first:last]


SQUARE = scene(2, box([0, 0], [8, 8]), cells=[8, 8])


@pytest.mark.parametrize(
    ("stress", "least", "most"),
    [
        (lambda x, y: 1.0 + 0.0 * x, 0.0, 1e-12),
        (lambda x, y: x - 4.0, 0.0, 1e-12),
        (lambda x, y: np.sin(2.0 * np.pi * x / 8.0), 0.0, 0.02),
        (lambda x, y: np.where(np.floor(2.0 * x) % 2 == 0, 1.0, -1.0), 1.0 - 1e-12, 1.0),
    ],
)
def test_stress_that_varies_within_cells(stress, least, most):
    """A gradient is none; stripes one particle wide are."""
    (found,) = body_states(load(SQUARE), Made(stress))
    assert least <= found.within_cells <= most
    assert np.isnan(found.stretch)


def test_volume_that_a_grid_does_not_hold_is_told(run):
    """Of a liquid that sinks into itself its particles hold more than the grid that they fill."""
    history = np.array(run.history)
    found = np.zeros(len(history), [(name, float) for name in history.dtype.names]
                     + [("volume.water", float), ("volume.water.particles", float)])  # fmt: skip
    for name in history.dtype.names:
        found[name] = history[name]
    found["volume.water"], found["volume.water.particles"] = 0.9, 1.0
    (one,) = (one for one in of_history(run.case, found) if one.name == "volume")
    assert one.value == pytest.approx(0.1) and one.where == "water"


def test_stretches_from_deformation_and_from_strain_are_the_same():
    """Stretched by 1.6 along x, turned by 30 degrees."""
    turn = np.array([[np.cos(0.5), -np.sin(0.5), 0], [np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]])
    F = turn @ np.diag([1.6, 0.8, 1.0])
    E = 0.5 * (F.T @ F - np.eye(3))
    strain = np.array([E[0, 0], E[1, 1], E[2, 2], E[0, 1], E[1, 2], E[0, 2]])
    for fields in ({"deformation": np.tile(F.ravel(), (256, 1))},
                   {"strain": np.tile(strain, (256, 1))}):  # fmt: skip
        (found,) = body_states(load(SQUARE), Made(lambda x, y: x, **fields))
        np.testing.assert_allclose([found.squeeze, found.stretch], [0.8, 1.6], rtol=1e-12)


@pytest.mark.parametrize(
    ("walls", "low", "high", "expected"),
    [
        ({}, [1, 1], [7, 4], 3.0),
        ({"y-min": "slip"}, [1, 0], [7, 3], 6.0),
        ({"y-min": "fixed"}, [1, 0], [7, 3], 3.0),
        ({"y-min": "slip", "y-max": "slip"}, [1, 0], [7, 8], 6.0),
        ({"y-min": "unilateral"}, [1, 0], [7, 3], 3.0),
    ],
)
def test_cells_across_a_body(walls, low, high, expected):
    """Mirrored at planes of symmetry; without the directions in which it fills the domain."""
    case = load(scene(2, box(low, high), cells=[8, 8], boundaries=walls))
    found = {one.name: one.value for one in of_case(case, boxes_of(case))}
    assert found["cells"] == pytest.approx(expected) and found["per-cell"] == 2.0


def test_steps_are_compared_with_the_stable_one():
    case = load(SQUARE)
    find = {one.name: one.value for one in of_case(case, {}, 0.9)}
    assert find["step"] == pytest.approx(0.9 / 0.45)
    assert "step" not in {one.name for one in of_case(case, {})}  # of unknown length in waves


def test_the_page_has_every_indicator_with_its_bound():
    """And pages that are there, with such a section."""
    text = (DOCS / "report.md").read_text()
    rows = dict(re.findall(r"^\| ([^|]+?) \| ([^|]+?) \|", text, re.MULTILINE))
    for rule in RULES.values():
        bound = f"{'from' if rule.least else 'up to'} {rule.number(rule.bound)}"
        assert rows[rule.label] == bound
        name, _, section = rule.page.partition("#")
        heads = re.findall("^#+ (.*)", (DOCS / name).read_text(), re.MULTILINE)
        anchors = [re.sub(r"[^\w -]", "", head).lower().replace(" ", "-") for head in heads]
        assert not section or section in anchors, rule.page


def test_what_cannot_be_read_says_nothing(run, monkeypatch):
    from pgimp.running import summary

    monkeypatch.setattr(summary, "of_run", lambda *_: (_ for _ in ()).throw(ValueError("odd")))
    assert summary.accuracy(run.path, SimpleNamespace()) == ""


def test_a_metal_that_flowed_in_the_initial_configuration_is_told(run):
    """As it is chosen for small strains; an elastic body may stretch as it likes."""
    steel = {"model": "von-mises", "young": 1e3, "poisson": 0.3, "density": 1.0,
             "yield-stress": 1.0}  # fmt: skip
    F = np.tile(np.diag([1.4, 1.0 / 1.4, 1.0]), (256, 1, 1))
    for material, told in ((steel, True), (SOFT, False)):
        case = scene(2, box([0, 0], [8, 8]), cells=[8, 8], materials={"soft": material})
        case["bodies"]["body"]["formulation"] = "total-lagrangian"
        made = Made(lambda x, y: 1.0 + 0.0 * x, deformation=F)
        made.number = 0
        every = of_frames(load(case), np.asarray(run.history), [made])
        found = [one for one in every if one.name == "flowed"]
        assert bool(found) == told
        assert all(abs(one.value - 0.4) < 1e-9 and not one.well for one in found)
