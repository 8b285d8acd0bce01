"""``pgimp check`` and ``pgimp bench`` as their users see them."""

import json
import re

import pytest
from tiers import wide

pytestmark = pytest.mark.slow(30)

COLUMN = """
format: 1
title: Column
dimensions: 1
grid: {origin: [0.0], size: [54.0], cell: [1.0]}
method: {shape: gimp, particles-per-cell: [2]}
time: {end: 2.0, step: 1.0e-4}
materials: {bar: {model: linear-1d, young: 1.0e6, density: 1.0}}
bodies: {bar: {material: bar, region: {box: {min: [0.0], max: [50.0]}}, velocity: [-10.0]}}
gravity: {table: [[0.0, [0.0]], [2.0, [-800.0]]]}
boundaries: {x-min: fixed}
"""


@pytest.fixture
def column(tmp_path):
    path = tmp_path / "column.yaml"
    path.write_text(COLUMN)
    return str(path)


def test_check_prints_what_the_paper_says(column, python):
    done = python(["-m", "pgimp", "check", "-v", column])
    assert done.returncode == 0, done.stderr
    text = done.stdout
    # c = sqrt(E/rho0), a transit of 50/c, 2.0/0.05 transits, dt (c + |v|)/L.
    assert "100 particles; wave speed 1000, travel time 0.05" in text
    assert "the run lasts 40 travel times" in text
    assert "20,000 to t = 2" in text
    assert "Courant 0.101" in text
    assert "strain by its own weight 0.04, by stopping its velocity 0.01" in text
    assert "warning" not in text
    assert re.search(r"memory (.*\n)+time .*particle-steps/s measured.*\n.*ranks", text)


@pytest.mark.parametrize(
    ("change", "status", "message"),
    [
        ("time.step=2e-3", 2, "Courant number of 2.02, beyond the stability limit"),
        ("time.step=8e-4", 0, "above 0.45 a free surface"),
        ("method.shape=mpm", 0, "above 0.1 a free surface"),
        ("materials.bar.young=1.0", 0, "one consistent set"),
        (
            "bodies.bar={material: bar, surface: whole, region: {box: {min: [0], max: [0.2]}}}",
            2,
            "bodies.bar.region: contains no particle",
        ),
    ],
)
def test_check_finds_what_a_run_would_meet(column, python, change, status, message):
    done = python(["-m", "pgimp", "check", column, "--set", change])
    assert done.returncode == status, done.stderr
    assert message in done.stdout + done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("ranks", [wide(1), 2])
def test_bench_reports_speed_and_error(mpirun, ranks):
    done = mpirun(ranks, ["-m", "pgimp", "bench", "--cells", "6", "--repeats", "1", "--json"])
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["ranks"] == ranks
    assert result["particles"] == 6**3 * 8
    assert result["particle_steps_per_second"] > 0
    assert set(result["phases"]) == {"P2G", "grid", "G2P", "sort", "exchange"}
    # The whole is slower than each phase, and the block falls freely but for rounding, which grows
    # with the noise of random positions.
    whole = result["particle_steps_per_second"]
    assert all(v is None or v > whole for v in result["phases"].values())
    assert result["error"]["velocity"] < 1e-6
    assert result["error"]["stress"] < 1e-6


def test_bench_is_the_same_on_any_number_of_ranks(mpirun):
    errors = []
    for ranks in (1, 3):
        done = mpirun(ranks, ["-m", "pgimp", "bench", "--cells", "5", "--repeats", "1", "--json"])
        errors.append(json.loads(done.stdout)["error"])
    assert errors[0] == errors[1]
