"""The study of contact: what it measures, in short, and that the page shows all of it."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from studies.contact import detection, gap, motion, problems, rolls, walls

from pgimp.kernels.loads.wall_gap import CLOSED

ROOT = Path(__file__).resolve().parents[2]


def test_gaps_of_flat_and_round_bodies():
    """Flat faces along the grid within 0.02 of a cell (0.016); disks, R = 5, within 0.05."""
    for shift in (0.3, 0.71):
        assert abs(gap.flat(2, 0.0, shift)) < 0.02
    assert abs(gap.balls(2, 5.0, 30.0, 0.3)) < 0.05


def test_two_ways_to_find_gap_and_normal():
    """Surface vectors are exact for planes; what is built is within 0.02, and 0.05 of disks."""
    rng, found = np.random.default_rng(5), {}
    for make in [partial(detection.flat, 2, [0.9, 0.3])] * 3:
        shift, *lattices = rng.random((3, 2)) - 0.5
        detection.measure(make, shift, lattices, found)
    assert max(map(abs, found["surfaces"].first)) < 1e-3
    assert np.sqrt(max(found["surfaces"].angles)) < 0.1
    assert max(map(abs, found["built"].first)) < 0.02
    found = {}
    for turn in (0.0, 0.4, 0.9):
        shift, *lattices = rng.random((3, 2)) - 0.5
        make = partial(detection.balls, 2, 5.0, [1.0, turn])
        detection.measure(make, shift, lattices, found)
    assert max(found["surfaces"].first) < 0.0  # they see the mean
    assert max(map(abs, found["built"].first)) < 0.05


@pytest.mark.parametrize("dimensions", [2, 3])
def test_momenta_at_the_vertices(dimensions):
    """To rounding in every step; what particles lose of it is much more, and less with `affine`."""
    on_grid, particles, momentum = rolls.collision(dimensions, 1.0)
    assert on_grid < 1e-12 and momentum < 1e-12
    assert 1e-4 < particles < 0.15


def test_blocks_that_stick():
    """What a block does on a slab it does tied to it, to a twentieth of a cell."""
    assert motion.sticking(0.1) < 0.05


def test_what_is_exact():
    assert motion.tied(100) < 1e-12
    assert motion.parting() == 0.0


def test_impacts_converge():
    """Rebound and loss of bars, and what edges turn, are better on finer cells."""
    (coarse, lost), (fine, less) = motion.bars(0.5), motion.bars(0.25)
    assert 0.9 < coarse < fine < 1.0
    assert 0.0 < less < lost < 0.1
    assert motion.edges(0.5) < 0.6 * motion.edges(1.0)


def test_a_block_is_pressed():
    """Ten cells high, by 30 %: the force to a tenth; to 2 % on the study's finer ones."""
    assert abs(problems.pressed(2.0) - 1.0) < 0.1


def test_rods_and_blocks_in_a_corner():
    """Rods touch and part within a per cent; forces of statics to a thousandth of a weight."""
    touch, part, rebound = problems.rods(40)
    assert abs(touch) < 0.015 and abs(part) < 0.01 and 0.95 < rebound < 1.0
    worst, off = problems.corner(0.5)
    assert worst < 1e-3 and off < 1e-9


def test_gaps_at_a_wall():
    """On the lattice within what counts as none, cut by the surface within 0.07 of a cell."""
    for low in (0.5, 1.0):
        region = {"box": {"min": [4.0, low], "max": [8.0, low + 3.0]}}
        assert abs(walls.first(region, 2, low)) <= CLOSED
    region = {"box": {"min": [4.0, 1.13], "max": [8.0, 4.0]}}
    assert -0.01 < walls.first(region, 2, 1.13) < 0.07 + CLOSED
    ball = {"ball": {"centre": [8.3, 5.2], "radius": 4.0}}
    assert -0.05 < walls.first(ball, 2, 1.2) < 0.05


def test_a_block_slides_down_a_wall():
    """To half a per cent, and it stays on the wall; with enough friction it sticks."""
    acceleration, sunk = walls.incline(1.0)
    assert abs(acceleration - 1.0) < 0.005 and -0.01 < sunk < 0.001
    slip, sunk = walls.incline(1.0, 24.0, 0.6)
    assert abs(slip) < 0.05 and abs(sunk) < 0.01


def test_the_page_shows_all_tables():
    page = (ROOT / "docs" / "contact-validation.md").read_text(encoding="utf-8")
    for name in ("motion", "gaps", "detection", "costs"):
        table = ROOT / "scripts" / "pages" / "tables" / f"contact-{name}.md"
        assert table.read_text(encoding="utf-8").strip() in page
