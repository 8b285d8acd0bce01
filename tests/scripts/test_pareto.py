"""scripts/pareto: its references, fronts and prices, a short ladder, and that the page shows it."""

from pathlib import Path

import numpy as np
import pytest
from studies.method import timoshenko
from studies.pareto.beam_mode import Mode, beam
from studies.pareto.candidates import METHODS, Method
from studies.pareto.front import front, price
from studies.pareto.ladders import ladder, once
from studies.pareto.large_bodies import Hertz, Impact, Vortex
from studies.pareto.small_bodies import Bending, Spinning, Waves

ROOT = Path(__file__).resolve().parents[2]


def test_the_beams_mode():
    """Timoshenko's beam of the same shape, whose warping is free; half as many elements."""
    rate, nodes, deflection, _ = timoshenko.slowest(16.0, 4.0)
    assert beam().rate == pytest.approx(4.0 * rate, rel=3e-3)
    assert Mode(4.0, 1.0, (16, 4)).rate == pytest.approx(beam().rate, rel=1e-4)
    places = np.column_stack([nodes / 4.0, np.full(len(nodes), 0.5)])
    shape, slope = beam().at(places)
    np.testing.assert_allclose(shape[:, 1] / shape[-1, 1], deflection, atol=3e-3)
    np.testing.assert_allclose(np.gradient(shape[:, 1], places[:, 0]), slope[:, 1, 0], atol=0.02)


def test_hertz_forces_add_up():
    """Half of the force, pi a p0/4 a half; the vertex at the plane of symmetry has half a tent."""
    problem = Hertz()
    problem.cell = 2.4e-3
    forces = problem.exact(10)
    half = 0.25 * np.pi * problem.half_width * problem.top
    assert forces.sum() == pytest.approx(half, rel=1e-6)
    assert forces[0] == pytest.approx(0.5 * problem.cell * problem.top, rel=0.01)
    assert not forces[6:].any()


def test_front_and_price():
    runs = [
        {"seconds": s, "error": e}
        for s, e in ((1.0, 0.4), (2.0, 0.5), (4.0, 0.1), (3.0, 0.2), (8.0, None), (9.0, 0.1))
    ]
    assert [r["seconds"] for r in front(runs)] == [1.0, 3.0, 4.0]
    steps = [{"seconds": 1.0, "error": 0.4}, {"seconds": 16.0, "error": 0.1}]
    assert price(steps, 0.2) == pytest.approx(4.0)
    assert price(steps, 0.5) == 1.0
    assert price(steps, 0.05) is None
    by_chance = [{"seconds": 0.5, "error": 0.05}, *steps]
    assert price(by_chance, 0.2) == pytest.approx(4.0)
    assert price([*steps, {"seconds": 64.0, "error": None}], 0.2) is None


def test_every_method_has_a_name_of_its_own():
    labels = [method.label for method in METHODS]
    assert len(set(labels)) == len(labels)
    assert {"gimp", "gimp, affine, initial, 1 a cell", "cpdi, affine, auto"} <= set(labels)


@pytest.mark.parametrize("D", [2, 3])
def test_a_wave_converges(D):
    """Second order: half the cell, a quarter of the error, and no run is free."""
    records = ladder(Waves(D), [Method("gimp", True)], (8, 16))
    coarse, fine = (record["error"] for record in records)
    assert 3.0 < coarse / fine < 6.0
    assert all(record["seconds"] > 0.0 and record["steps"] > 10 for record in records)


@pytest.mark.parametrize("problem", [Bending(2), Vortex(), Spinning(2), Hertz(), Impact()])
def test_problems_run(problem):
    """On few cells, where errors are large but not those of another problem."""
    if isinstance(problem, Impact):
        problem.fine = 16
    found = once(problem, Method("gimp", True), problem.quick)
    assert 0.0 < found["error"] < 0.9


def test_the_page_shows_all_tables():
    page = (ROOT / "docs" / "error-against-cost.md").read_text(encoding="utf-8")
    for name in ("fronts", "prices", "origin"):
        table = ROOT / "scripts" / "pages" / "tables" / f"pareto-{name}.md"
        assert table.read_text(encoding="utf-8").strip() in page
