"""The performance model: against numbers by hand, its limits, and as users see it."""

import json
import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mentioned import mentions
from scenes import write_case
from tiers import wide
from two_blocks import flying

from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.decomposition.slabs import cut
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.bodies.extent import extents
from pgimp.scene.scene import Scene
from pgimp.solver.simulation import Simulation
from pgimp.solver.start.memory import estimate
from pgimp.utilities.model.block import Block, block_case, block_layout
from pgimp.utilities.model.costs import Costs, Messages, Network
from pgimp.utilities.model.layout import Layout, layout_now, layout_of
from pgimp.utilities.model.measure import costs_of, run_in_turn
from pgimp.utilities.model.predict import EFFICIENT, pays_off, predict
from pgimp.utilities.model.report import lines, rank_counts, scaling
from pgimp.utilities.model.sample import Sample, samples_of
from pgimp.utilities.model.sample_cases import resized

US = 1e-6
FREE = Messages(0.0, 1e30, 0.0, 0.0)
NETWORK = Network()


def even(layers, each, **parts):
    """Layers of equally many particles; supports of three vertices a direction."""
    return Layout(np.full(layers, each, np.int64), **{"plane": 100, "vertices": 3} | parts)


def test_one_rank_costs_what_its_parts_cost():
    costs = Costs(50 * US, ((1000.0, 1e-7),), 1e-8, 0.5, Messages())
    step = predict(even(10, 1000), costs, NETWORK, 1)
    # All planes of ten layers take part, and two more.
    assert step.seconds == pytest.approx(50 * US + 1e4 * 1e-7 + 12 * 100 * 1e-8)
    assert (step.slabs, step.most, step.exchange) == (1, 10_000, 0.0)
    assert step.efficiency(step) == 1.0


def test_several_ranks_pay_for_messages_planes_and_uneven_layers():
    messages = Messages(neighbour=30 * US, bandwidth=1e9, reduction=3 * US, migrant=1 * US)
    costs = Costs(50 * US, ((1000.0, 1e-7),), 1e-8, 0.0, messages)
    layout = even(14, 1000, crossing=0.01)
    step = predict(layout, costs, NETWORK, 4)
    # Four layers at most, of a rank with two neighbours: two planes come up, three partial ones
    # come down, three are added for each neighbour.
    slabs = np.diff(cut(layout.counts, 4, 2))
    assert slabs.max() == 4 and slabs.sum() == 14
    work = 4e3 * 1e-7 + 6 * 100 * 1e-8
    inner = 2 * 30 * US + 2 * 1000 * 0.01 * 1 * US
    wire = (2 + 3) * 6400 / 1e9
    added = 2 * 3 * 100 * 1e-8
    busiest = [0.0] * 4
    for rank, layers in enumerate(slabs):
        sides = 1 + (0 < rank < 3)
        busiest[rank] = (
            layers * 1e-4 + (layers + 2) * 1e-6 + sides * (40 * US + 3 * 1e-6)
            + ((2 if rank > 0 else 0) + (3 if rank < 3 else 0)) * 6400 / 1e9
        )  # fmt: skip
    expected = 50 * US + max(busiest) + 2 * 3 * US
    assert step.seconds == pytest.approx(expected)
    assert step.seconds <= 50 * US + work + inner + wire + added + 2 * 3 * US + 1e-12
    assert step.reduction == pytest.approx(2 * 3 * US)
    assert step.fixed + step.mean + step.excess + step.planes + step.calls + step.reduction == (
        pytest.approx(step.seconds)
    )


def test_messages_hide_behind_inner_layers():
    slow = FREE._replace(bandwidth=1e7)
    layout = even(200, 1000)
    waits = predict(layout, Costs(0.0, ((1.0, 1e-6),), 0.0, 0.0, slow), NETWORK, 2)
    hides = predict(layout, Costs(0.0, ((1.0, 1e-6),), 0.0, 0.5, slow), NETWORK, 2)
    assert waits.planes == pytest.approx(3 * 6400 / 1e7)
    assert hides.planes == 0.0
    # Two layers a rank: nothing is inside.
    thin = even(4, 1000)
    hides = predict(thin, Costs(0.0, ((1.0, 1e-6),), 0.0, 0.5, slow), NETWORK, 2)
    assert hides.planes == pytest.approx(3 * 6400 / 1e7)


def test_between_nodes_the_network_counts():
    costs = Costs(0.0, ((1.0, 1e-7),), 0.0, 0.0, FREE)
    near = predict(even(64, 2000), costs, Network(1.0, 1e9, 8), 8)
    far = predict(even(64, 2000), costs, Network(1.0, 1e9, 4), 8)
    assert near.calls == near.reduction == 0.0
    # Particles' message hides behind all work but that on the outer layers, one each.
    assert far.calls == pytest.approx(1.0 - 16e3 * 1e-7 * 6 / 8)
    assert far.reduction == pytest.approx(1.0)
    assert far.planes == pytest.approx(1.0 + (2 + 3) * 6400 / 1e9)
    # Of short latencies nothing is left where there is work enough, half of it in P2G.
    halves = costs._replace(interior=0.5)
    soon = predict(even(64, 2000), halves, Network(100 * US, 1e12, 4), 8)
    assert soon.calls == soon.planes == soon.reduction == 0.0


counts = st.lists(st.integers(0, 5000), min_size=5, max_size=60).filter(any)


@settings(max_examples=60, deadline=None)
@given(
    counts=counts,
    s=st.integers(2, 4),
    ranks=st.integers(1, 40),
    fixed=st.floats(0.0, 1e-3),
    neighbour=st.floats(0.0, 1e-3),
)
def test_no_prediction_beats_the_work_shared(counts, s, ranks, fixed, neighbour):
    layout = Layout(np.array(counts), 10, s)
    costs = Costs(fixed, ((1.0, 1e-7),), 1e-9, 0.5, Messages(neighbour))
    step, one = predict(layout, costs, NETWORK, ranks), predict(layout, costs, NETWORK, 1)
    assert step.seconds >= fixed + layout.particles * 1e-7 / ranks - 1e-15
    assert step.efficiency(one) <= 1.0 + 1e-9
    cuts = cut(layout.counts, ranks, s - 1)
    assert step.slabs == len(cuts) - 1 <= layout.most_ranks
    assert step.most == max(sum(counts[a:b]) for a, b in pairwise(cuts))
    # More ranks than slabs only wait longer.
    most = predict(layout, costs, NETWORK, layout.most_ranks)
    beyond = predict(layout, costs, NETWORK, 3 * layout.most_ranks)
    assert beyond.slabs == most.slabs == layout.most_ranks
    assert beyond.seconds >= most.seconds - 1e-15
    one, best, limit = pays_off(layout, costs, NETWORK)
    assert best.efficiency(one) >= EFFICIENT and best.ranks <= layout.most_ranks and limit


def test_what_limits_is_named():
    def limit(layers, each, messages=FREE, vertex=0.0, fixed=0.0, plane=100):
        costs = Costs(fixed, ((1.0, 1e-7),), vertex, 0.0, messages)
        return pays_off(even(layers, each, plane=plane), costs, NETWORK)

    mentions(limit(100, 1000)[2], "layers", "50 ranks")
    assert "latency" in limit(100, 1000, FREE._replace(neighbour=60 * US))[2]
    assert "planes" in limit(100, 1000, FREE._replace(bandwidth=2e8))[2]
    assert "fixed cost" in limit(100, 1000, fixed=1e-3)[2]
    uneven = Layout(np.array([10, 10, 10, 1000, 10, 10, 10, 10, 10, 10]), 1, 3)
    assert "differ" in pays_off(uneven, Costs(0.0, ((1.0, 1e-7),), 0.0, 0.0, FREE), NETWORK)[2]
    # Up to the number asked for nothing limits.
    _, best, why = pays_off(even(100, 1000), Costs(0.0, ((1.0, 1e-7),), 0.0, 0.0, FREE), NETWORK, 8)
    assert (best.ranks, why) == (8, "")


def test_ten_billion_particles_on_ten_thousand_ranks():
    scene, bodies, layout = block_layout(1077, 1, True)
    assert layout.particles == pytest.approx(1e10, rel=1e-3)
    costs = Costs(50 * US, ((5e3, 9e-8), (2e5, 1e-7)), 1e-8, 0.4, Messages())

    def memory(step):
        share = step.most / layout.particles
        return estimate(scene, step.ranks, True, bodies, layout.particles, share).size

    found = scaling(layout, costs, NETWORK, memory)
    steps = found["steps"]
    assert [step["ranks"] for step in steps][:: len(steps) - 1] == [1, 10_000]
    # 1077 cells have particles in 1078 layers; eight cells around.
    assert found["slabs"] == layout.most_ranks == (1077 + 8 + 1 + 2 * 2) // 2
    assert steps[0]["seconds"] == pytest.approx(1e3, rel=0.02)
    upto = [step for step in steps if step["ranks"] <= found["slabs"]]
    memory = [step["memory"] for step in upto]
    assert memory == sorted(memory, reverse=True)
    assert memory[0] > 3e12 and memory[-1] < 3e10
    assert steps[-1]["slabs"] == found["slabs"]
    text = "\n".join(lines(steps, lambda step: ""))
    assert "10,000" in text and "nan" not in text


def test_a_ladder_of_ranks():
    assert rank_counts((3,), 8) == [1, 2, 3, 4, 8]
    assert rank_counts((22, 99), 20) == [1, 2, 4, 8, 16, 20]


def test_the_layout_is_that_of_the_run():
    case = Case.model_validate(flying())
    sim = Simulation(case, Serial())
    sim.advance()
    now = layout_now(sim)
    of = Scene(case)
    lattice, found, _ = count_particles(of, Serial())
    before = layout_of(of, extents(case), lattice.coordinates[0], found.sum(axis=0))
    np.testing.assert_array_equal(now.counts, before.counts)
    assert (now.vertices, now.ends) == (before.vertices, before.ends)
    assert now.plane <= before.plane <= now.plane + 2  # bodies may lie anywhere in their cells
    # Half of the particles move by a hundredth of a cell.
    assert now.crossing == pytest.approx(0.005)


@pytest.mark.parametrize("random", [True, False])
def test_the_layout_of_a_block_that_is_not_made(random):
    sim = (Block if random else Simulation)(Case.model_validate(block_case(6, 10)), Serial())
    begin = layout_now(sim)
    _, _, layout = block_layout(6, 1, random)
    assert layout.particles == begin.particles == 8 * 6**3
    # Some lattice planes lie where layers meet: of them it decides how they are rounded.
    np.testing.assert_allclose(layout.counts, begin.counts, atol=120 if random else 0)
    assert begin.plane <= layout.plane <= (begin.plane**0.5 + 2) ** 2
    sim.advance()
    assert layout.crossing == pytest.approx(layout_now(sim).crossing)


def test_measured_and_predicted_agree_roughly():
    case = Case.model_validate(flying())
    samples = samples_of(case, 72, Serial(), [72, 4000])
    target = Sample(lambda: Simulation(resized(case, 0.2), Serial()), Serial())
    run_in_turn([*samples, target], Serial(), 0.3, 5)
    costs = costs_of(samples)
    assert costs.fixed > 0.0 and costs.vertex >= 0.0 and 0.0 < costs.interior < 1.0
    step = predict(layout_now(target.sim), costs, NETWORK, 1)
    # Each has a share of what other tests take of the machine: 2.6 was seen.
    assert 0.25 < step.seconds / target.seconds() < 4.0


@pytest.mark.parametrize("ranks", [wide(1), 2])
def test_bench_model_as_json(mpirun, ranks):
    words = ["bench", "--model", "--cells", "4", "--repeats", "1", "--particles", "300", "--json"]
    done = mpirun(ranks, ["-m", "pgimp", *words, "--ranks-per-node", "5", "--latency", "1e-5"])
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["ranks"] == ranks
    assert result["network"] == {"latency": 1e-5, "bandwidth": 1e10, "ranks_per_node": 5}
    assert [one["ranks"] for one in result["measured"]] == [1, 2][:ranks]
    assert all(one["predicted"] > 0.0 and one["particles"] == 512 for one in result["measured"])
    assert result["costs"]["messages"]["measured"] is (ranks == 2)
    strong, weak = result["strong"], result["weak"]
    assert strong["particles"] == 216 and strong["pays_off"] <= strong["slabs"] < 10
    assert strong["steps"][0]["efficiency"] == weak[0]["efficiency"] == 1.0
    assert strong["steps"][-1]["ranks"] == weak[-1]["ranks"] == 10_000
    assert weak[-1]["memory"] > weak[0]["memory"] > 1e8


@pytest.mark.parametrize(
    "words", [["--particles", "1e11"], ["--latency", "-1"], ["--ranks-per-node", "0"]]
)
def test_bench_refuses_what_it_cannot_model(words, capsys):
    assert main(["bench", "--model", *words]) == 2
    assert f"{words[0]}: expected a number from" in capsys.readouterr().err


def test_check_recommends_a_number_of_ranks(tmp_path, capsys):
    write_case(tmp_path / "case.yaml", flying())
    assert main(["check", "-v", str(tmp_path / "case.yaml")]) == 0
    text = capsys.readouterr().out
    found = re.search(r"ranks +(?:up to )?(\d+)[; ].*pay off \(efficiency above 70%\)", text)
    assert found, text
    table = text[found.end() :]
    assert re.search(rf"^ +{found[1]} .* efficiency is above 70% up to here", table, re.MULTILINE)
    # Twelve cells and two rows of ghost vertices to either side.
    assert re.search(r"^ +8 .*slabs stop here", table, re.MULTILINE)
    assert "messages on a node" in text and "assumed" in text


def test_all_cores_at_once_are_slower_than_one():
    costs = Costs(50 * US, ((1.0, 1e-7),), 0.0, 0.0, FREE, busy=1.25)
    one, two = (predict(even(64, 1000), costs, NETWORK, ranks) for ranks in (1, 2))
    assert one.seconds == pytest.approx(50 * US + 64e3 * 1e-7)
    assert two.seconds == pytest.approx(50 * US + 1.25 * 32e3 * 1e-7)
