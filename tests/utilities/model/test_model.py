"""The cost of a step: its parts, ranks that pay off, and as users see it."""

import re

import numpy as np
import pytest
from scenes import write_case
from two_blocks import flying

from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.scene import Scene
from pgimp.solver.simulation import Simulation
from pgimp.utilities.check import cost
from pgimp.utilities.model.costs import Costs
from pgimp.utilities.model.measure import costs_of, run_in_turn
from pgimp.utilities.model.sample import Sample, samples_of
from pgimp.utilities.model.sample_cases import resized

US = 1e-6


def test_work_is_that_of_particles_and_vertices():
    costs = Costs(50 * US, ((1000.0, 1e-7), (100_000.0, 2e-7)), 1e-8)
    assert costs.work(1000, 500) == pytest.approx(1e-4 + 5e-6)
    assert costs.work(10_000, 0.0) == pytest.approx(1.5e-3)  # halfway, by the logarithm


@pytest.mark.parametrize(("fixed", "work"), [(0.0, 1e-2), (100 * US, 1e-2), (1e-3, 1e-3)])
def test_ranks_pay_off_while_each_has_enough_to_do(fixed, work):
    def efficiency(ranks):
        step = fixed + (cost._MESSAGES if ranks > 1 else 0.0) + work / ranks
        return (fixed + work) / (ranks * step)

    ranks = cost.ranks_that_pay(fixed, work, 10_000)
    assert efficiency(ranks) >= 0.7 > efficiency(ranks + 1)
    assert cost.ranks_that_pay(fixed, 1e3 * work, 8) == 8


def test_active_planes_are_those_of_the_run():
    case = Case.model_validate(flying())
    sim = Simulation(case, Serial())
    sim.advance()
    scene = Scene(case)
    lattice, counts, _ = count_particles(scene, Serial())
    assert cost._active_planes(scene, lattice, counts) == sim.rank.grid.active.sum()


def test_measured_and_predicted_agree_roughly():
    case = Case.model_validate(flying())
    samples = samples_of(case, 72, [72, 4000])
    target = Sample(lambda: Simulation(resized(case, 0.2), Serial()))
    run_in_turn([*samples, target], 0.3, 5)
    costs, grid = costs_of(samples), target.sim.rank.grid
    assert costs.fixed > 0.0 and costs.vertex >= 0.0
    vertices = float(grid.active.sum() * np.prod(grid.window.extent[1:]))
    step = costs.fixed + costs.work(target.sim.present(), vertices)
    # Each has a share of what other tests take of the machine: 2.6 was seen.
    assert 0.25 < step / target.seconds() < 4.0


def test_check_recommends_a_number_of_ranks(tmp_path, capsys):
    write_case(tmp_path / "case.yaml", flying())
    assert main(["check", "-v", str(tmp_path / "case.yaml")]) == 0
    text = capsys.readouterr().out
    found = re.search(r"ranks +(?:up to )?(\d+)[; ].*pay off \(efficiency above 70%\)", text)
    assert found, text
    # Twelve cells and two rows of ghost vertices to either side.
    assert "layers of the grid are for 8 ranks at most" in text and "us without particles" in text
