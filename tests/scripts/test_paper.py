"""What the paper finds (sections 4.1 to 4.4), from a quick run of scripts/paper.

Cells of 10 to 0.25 in place of 50 to 0.05, with a step of 1.25e-4, and of 5e-5 for mpm; the
figures' own runs of the column and the shock are those of the whole reproduction. Tolerances are
about half the margin that was measured, which stands beside each; the same bits come out on any
machine of one kind, and rounding elsewhere changes noise, not its size.
"""

import csv
import json
import sys
from math import log
from pathlib import Path

import pytest
from processes import run

pytestmark = [pytest.mark.slow(270), pytest.mark.wide]

ROOT = Path(__file__).resolve().parents[2]
FIGURES = [f"fig{n:02}" for n in range(4, 12)] + [f"fig{n:02}-fuzzy" for n in range(4, 11)]
WEIGHTS = {10000: 0.5, 12000: 0.6, 30000: 1.5, 40000: 2.0}
TRANSIT = 0.05
GHOSTS = ("fuzzy-nearest-fixed", "fuzzy-constant-fixed")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of a quick reproduction."""
    folder = tmp_path_factory.mktemp("paper")
    # One process: a second one would compile the same kernels at the same time, and takes a core
    # from the tests beside.
    words = [sys.executable, ROOT / "scripts/drawing/paper.py", "--quick", "-j", "1", "-o", folder]
    done = run([str(word) for word in words], timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.fixture(scope="module")
def rows(folder):
    """All rows of errors.csv, numbers as numbers."""
    with open(folder / "errors.csv", encoding="utf-8") as file:
        return [{k: number(v) for k, v in row.items()} for row in csv.DictReader(file)]


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


@pytest.fixture(scope="module")
def pick(rows):
    """``pick(name, problem, **fields)`` is the only row with these fields that was not stopped."""

    def find(method, problem, time, **fields):
        wanted = {"method": method, "problem": problem, "time": pytest.approx(time)} | fields
        found = [row for row in rows if all(row[k] == v for k, v in wanted.items())]
        assert len(found) == 1, wanted
        assert found[0]["state"] == "done", wanted
        return found[0]

    return find


@pytest.fixture(scope="module")
def column(pick):
    """``column(method, weight)`` is the row of figure 4 or 5."""

    def find(method, weight):
        step = 2e-5 if method.startswith("mpm") else 1e-4
        same = {"cell": 1.0, "particles-per-cell": 2.0, "step": step}
        return pick(method, "column", WEIGHTS[weight], **same)

    return find


@pytest.fixture(scope="module")
def shock(pick):
    """``shock(method, transits)`` is the row of figures 6 to 9."""

    def find(method, transits, per_cell=2.0):
        return pick(method, "shock", TRANSIT * transits, particles_per_cell=per_cell)

    return find


@pytest.fixture(scope="module")
def error(pick):
    """``error(method, per_cell, cell)`` is a point of figure 10."""

    def find(method, per_cell, cell):
        step = 5e-5 if method == "mpm" else 1.25e-4
        same = {"particles-per-cell": per_cell, "cell": cell, "speed": 1.0, "step": step}
        return pick(method, "column", 0.5, **same)["error"]

    return find


def order(coarse, fine, ratio):
    """Order of convergence from two errors."""
    return log(coarse / fine) / log(ratio)


def test_every_figure_is_drawn(folder):
    for name in FIGURES:
        assert (folder / f"{name}.png").stat().st_size > 20_000, name
    page = (folder / "errors.md").read_text(encoding="utf-8")
    assert "pgimp" in page and "numba" in page and page.count("\n## ") == 4


def test_the_error_is_the_one_of_the_history(rows):
    """Here (42) with NumPy, there with the waves, which vanish at multiples of two transits."""
    found = [
        (row["error"], row["error_dynamic"])
        for row in rows
        if row["problem"] == "column" and row["state"] == "done"
        and round(row["time"] / (2 * TRANSIT), 6).is_integer()
    ]  # fmt: skip
    assert len(found) > 100
    assert all(dynamic == pytest.approx(static, rel=1e-6) for static, dynamic in found)


def test_mpm_is_fine_until_the_first_cell_crossing_and_noisy_after(column):
    """Figure 4: between W = 10000 and 12000 the first particles change cells."""
    for method in ("mpm", "mpm-tracked"):
        assert column(method, 10000)["worst"] < 0.015  # measured 0.010 and 0.012
        for weight in (12000, 30000, 40000):
            assert column(method, weight)["worst"] > 0.1  # measured 0.15 to 0.44
            assert column(method, weight)["error"] > 3.0 * column("finite-gimp", weight)["error"]


def test_gimp_stays_smooth(column):
    """Figures 4 and 5: no particle is far from the rest."""
    for weight in WEIGHTS:
        # The stairs within cells are a quarter of a cell of 1, 0.5 % of W.
        assert column("gimp-tracked", weight)["worst"] < 0.02  # measured at most 0.013
        assert column("finite-gimp", weight)["worst"] < 0.008  # measured at most 0.006
        assert column("gimp", weight)["worst"] < 0.08  # light, see below; measured 0.055
    for weight in (12000, 30000, 40000):
        assert column("gimp", weight)["worst"] < 0.25 * column("mpm", weight)["worst"]


def at_the_wall(folder, method):
    """Mean deviation from (42) of the two particles at the wall, W = 40000, over W."""
    stored = json.loads((folder / "runs.json").read_text())["runs"]
    (records,) = [
        entry["records"]
        for entry in stored
        if entry["run"]["problem"] == "column" and entry["run"]["profile"]
        and entry["run"]["method"] == method and entry["run"]["step"] == 1e-4
    ]  # fmt: skip
    b, young, length = -800.0, 1.0e6, 49.0
    pairs = list(zip(records[-1]["x"], records[-1]["stress"], strict=True))[:2]
    exact = [young * ((2 * b * (length - x) / young + 1) ** 0.5 - 1) for x, _ in pairs]
    return sum(s - e for (_, s), e in zip(pairs, exact, strict=True)) / 2 / 40000


def test_gimp_is_light_at_the_wall_and_tracking_cures_it(folder):
    """Figure 5(b): GIMP of the paper underestimates the weight, Finite GIMP does not."""
    assert 0.03 < at_the_wall(folder, "gimp") < 0.07  # measured 0.046
    for method in ("gimp-tracked", "finite-gimp", "fuzzy-nearest", "fuzzy-constant"):
        assert abs(at_the_wall(folder, method)) < 0.005  # measured at most 0.003


def test_mpm_gets_worse_below_some_cell_size(error, rows):
    """Figure 10: the best cell is the finest in which no particle leaves its own, or near it."""
    for per_cell in (1, 2, 4):
        best = min(error("mpm", per_cell, cell) for cell in (10.0, 5.0, 2.5, 1.0))
        assert error("mpm", per_cell, 0.5) > 1.4 * best  # measured 7, 4.6 and 1.4 times
    # Four a cell have changed cells at a cell of 1 already, as the paper says.
    assert error("mpm", 4, 1.0) > 2.0 * error("mpm", 2, 1.0)


def test_gimp_ends_on_a_plateau_with_initial_volumes_only(error):
    """Figure 10; volumes that shrink by up to W/E make most of it, not what the wall loses."""
    for per_cell in (1, 2, 4):
        assert 1.4e-3 < error("gimp", per_cell, 0.25) < 2.0e-3  # measured 1.7e-3
    assert error("gimp", 1, 0.25) > 0.8 * error("gimp", 1, 1.0)
    for per_cell in (1, 2):
        # Measured a fiftieth and a sixth, and falling.
        assert error("gimp-tracked", per_cell, 0.25) < 0.3 * error("gimp", per_cell, 0.25)
        assert error("gimp-tracked", per_cell, 0.25) < 0.4 * error("gimp-tracked", per_cell, 1.0)


def test_finite_gimp_converges_best_of_the_papers_methods(error):
    for per_cell in (1, 2, 4):
        others = [error("gimp", per_cell, 0.25)]
        # mpm stops at these cells: its last result.
        others.append(error("mpm", per_cell, 0.5))
        assert error("finite-gimp", per_cell, 0.25) < 0.35 * min(others)  # 4 a cell: 0.22
    # Particles that change cells leave waves behind, which make the line bumpy, so its ends count;
    # measured 1.6, and 1.8 and 1.6 where the stairs in a cell (order 1) no longer dominate.
    assert order(error("finite-gimp", 1, 10.0), error("finite-gimp", 1, 0.25), 40.0) > 1.4
    assert order(error("finite-gimp", 2, 1.0), error("finite-gimp", 2, 0.25), 4.0) > 1.5
    assert order(error("finite-gimp", 4, 1.0), error("finite-gimp", 4, 0.25), 4.0) > 1.3


def test_fewer_particles_a_cell_are_better_for_gimp(error):
    """Figure 10, and at twice or four times the particles."""
    for cell in (10.0, 5.0, 2.5, 1.0, 0.5, 0.25):
        for method in ("gimp-tracked", "finite-gimp"):
            # Measured at most 0.28 for tracked volumes at 0.5, 0.29 for Finite GIMP.
            assert error(method, 1, cell) < 0.4 * error(method, 2, cell)
        if cell >= 1.0:  # where it is not yet on its plateau
            assert error("gimp", 1, cell) < 0.6 * error("gimp", 2, cell)
            assert error("gimp", 2, cell) < 1.01 * error("gimp", 4, cell)


def test_the_ramps_waves_set_a_floor_that_moves_with_its_speed(pick):
    """Figure 11. Where the waves do not vanish, statics is wrong by what they are, at any cell.

    A transit after W = 10000 they are at their greatest, (L^2 - Z^2)/(2 c) in place of 0 beside a
    strain of (L - Z) t, both times b'/c^2: in the mean a third of a transit over t. Measured 0.109,
    0.0299, 0.0080 for a ramp five times faster, the paper's, and one four times slower. Against the
    solution with the waves there is no floor.
    """
    same = {"particles-per-cell": 1.0}
    floors = {}
    for speed in (5.0, 1.0, 0.25):
        time = 0.5 / speed
        later = [
            pick("finite-gimp", "column", time + TRANSIT, speed=speed, cell=cell, **same)
            for cell in (2.5, 1.0, 0.5)
        ]
        floors[speed] = later[-1]["error"]
        assert later[0]["error"] == pytest.approx(floors[speed], rel=0.05)
        assert all(row["error_dynamic"] < 0.1 * row["error"] for row in later)
        assert floors[speed] == pytest.approx(TRANSIT / (time + TRANSIT) / 3, rel=0.03)
    assert floors[5.0] > 3.0 * floors[1.0] > 9.0 * floors[0.25]
    # At the paper's instant no floor is left: the line falls on with the cells.
    fine = [pick("finite-gimp", "column", 0.1, speed=5.0, cell=c, **same) for c in (2.5, 0.25)]
    assert order(fine[0]["error"], fine[1]["error"], 10.0) > 1.4  # measured 1.7


def test_tracked_mirrored_fuzzy_particles_converge_at_second_order(error):
    """fuzzy-constant whatever the particles a cell; fuzzy-nearest once its stairs are smeared."""
    for per_cell in (1, 2, 4):
        coarse, fine = (error("fuzzy-constant", per_cell, cell) for cell in (10.0, 0.25))
        assert 1.6 < order(coarse, fine, 40.0) < 2.2  # measured 1.8, 1.7, 1.8
    for per_cell in (1, 2):
        coarse, fine = (error("fuzzy-nearest", per_cell, cell) for cell in (1.0, 0.25))
        assert 1.6 < order(coarse, fine, 4.0) < 2.2  # measured 2.0, 1.9
    # With one a cell both are the same tent.
    assert error("fuzzy-nearest", 1, 1.0) == error("fuzzy-constant", 1, 1.0)


def test_fuzzy_particles_lose_at_a_wall_without_mirror(column):
    """They reach past it from the start; the second particle then carries what is lost."""
    for method, part in zip(GHOSTS, (0.134, 0.314), strict=True):
        assert column(method, 10000)["worst"] == pytest.approx(part, abs=0.01)
    for method in ("fuzzy-nearest", "fuzzy-constant"):
        for weight in WEIGHTS:
            assert column(method, weight)["worst"] < 0.008  # measured at most 0.005


def test_stress_behind_the_shock(shock):
    """Figures 6 and 7: -20000 behind the front (46)."""
    for method in ("finite-gimp", "gimp-tracked", "fuzzy-nearest", "fuzzy-constant"):
        for transits in (0.75, 1.0):
            # Measured within 0.2 %, of fuzzy-constant 0.9 %: whole waves fit in behind the front.
            assert shock(method, transits)["mean_behind"] == pytest.approx(-20000.0, rel=0.015)
    for transits in (0.75, 1.0):
        assert shock("gimp", transits)["mean_behind"] == pytest.approx(-20000.0, rel=0.02)


def test_gimp_is_smoother_than_mpm_behind_the_shock(shock):
    """Figures 6, 7 and 9: alike before particles change cells (0.25), then MPM has spikes."""
    assert shock("mpm", 0.25)["jump_behind"] < shock("gimp", 0.25)["jump_behind"]
    for per_cell in (1.0, 2.0, 4.0):
        for transits in (0.75, 1.0):
            jump = shock("mpm", transits, per_cell)["jump_behind"]
            for method in ("gimp", "gimp-tracked", "finite-gimp"):
                # Measured a fifth at most, with four a cell.
                assert shock(method, transits, per_cell)["jump_behind"] < 0.3 * jump


def test_finite_gimp_has_the_stress_of_the_shock_where_gimp_is_light(shock):
    """Figure 8, after one transit: measured -19978 against -19754."""
    for per_cell in (1.0, 2.0, 4.0):
        finite = abs(shock("finite-gimp", 1.0, per_cell)["mean_behind"] + 20000.0)
        light = shock("gimp", 1.0, per_cell)["mean_behind"] + 20000.0
        assert finite < 60.0 and 150.0 < light < 350.0
