"""Slab boundaries follow the load, when that pays, and no bit depends on where they are."""

import itertools
import json
import re
import shutil

import numpy as np
import pytest
from balance_scenes import column, crossing
from hypothesis import given, settings
from hypothesis import strategies as st
from loaded_block import loaded
from processes import PROGRAMS
from rank_scenes import GRID, PROBES, SCENES, SIZED
from rank_threads import Comm, together
from run_files import digests, go_back
from scenes import write_case

import pgimp
from pgimp.decomposition import redistribute
from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab, cut, imbalance_of, slab_of
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.particles import Particles
from pgimp.physics.shapes.mpm import MpmParameters

pytestmark = pytest.mark.slow(150)

# -- where to cut


@settings(max_examples=150, deadline=None)
@given(
    costs=st.lists(st.sampled_from([0.0, 0.0, 1.0, 2.5, 5.0, 40.0]), min_size=4, max_size=12),
    ranks=st.integers(2, 4),
    width=st.integers(1, 3),
    ends=st.integers(0, 4),
)
def test_cuts_are_the_best_there_are(costs, ranks, width, ends):
    """Against all ways to cut: the most expensive rank, then the sum of squares."""
    costs = np.array(costs)
    cuts = cut(costs, ranks, width, ends)
    active, layers, ends = len(cuts) - 1, len(costs), max(width, ends)
    if not costs.any():
        costs = np.ones(layers)

    def rating(inner):
        parts = np.add.reduceat(costs, [0, *inner])
        return parts.max(), (parts**2).sum()

    every = []
    for inner in itertools.combinations(range(1, layers), active - 1):
        widths = np.diff([0, *inner, layers])
        if active == 1 or (min(widths) >= width and min(widths[0], widths[-1]) >= ends):
            every.append(rating(inner))
    assert rating(cuts[1:-1]) == pytest.approx(min(every))
    if active < ranks:  # one more would be too thin
        assert layers < 2 * ends + (active - 1) * width


def test_every_rank_gets_work_where_the_body_is():
    """Twenty layers in a long domain, on eight ranks of two layers at least."""
    costs = np.zeros(1000)
    costs[300:320] = 100.0
    parts = np.add.reduceat(costs, cut(costs, 8, 2)[:-1])
    assert sorted(parts) == [200.0] * 4 + [300.0] * 4


def test_many_ranks_are_cut_well_and_fast():
    costs = np.random.default_rng(1).random(20000)
    assert imbalance_of(costs, cut(costs, 1000, 2)) < 0.1


# -- how layers change hands

CELLS, EXTRA = 18, 1
FRAME = Frame((0.0,), (1.0,), (1.0,), (CELLS,), EXTRA)
LAYERS = FRAME.vertices[0]


def owned(cuts, rank, extra=0):
    """Layers of a rank, or with `extra` its planes, as a slice."""
    last = rank == len(cuts) - 2
    return slice(cuts[rank], cuts[rank + 1] + extra * last) if rank < len(cuts) - 1 else slice(0, 0)


@settings(max_examples=60, deadline=None)
@given(data=st.data(), seed=st.integers(0, 2**32), piece=st.sampled_from([1, 40, 10**6]))
def test_layers_go_to_any_rank_with_all_they_have(data, seed, piece):
    """Between six ranks and one without layers, whichever others they come from."""
    edges = st.lists(st.integers(1, LAYERS - 1), min_size=5, max_size=5, unique=True)
    old, new = ([0, *sorted(data.draw(edges)), LAYERS] for _ in range(2))
    rng = np.random.default_rng(seed)
    n = 60
    p = Particles.empty(n, Carried(1))
    p.x[:, 0] = rng.uniform(0.0, CELLS, n)
    p.id[:], p.m[:] = rng.permutation(n), rng.uniform(1.0, 2.0, n)
    shape, whole = MpmParameters((0.0,)), Slab(0, LAYERS, None, None)
    everyone = Population(p, n, shape, FRAME, whole)
    p.cell[:] = rng.integers(0, 3, n)  # as of some time ago
    order = np.lexsort((p.id, p.cell, p.layer))
    sums = rng.normal(size=(LAYERS + EXTRA, 2, 3)), np.zeros((LAYERS + EXTRA, 0, 4))

    boxes, ranks = {}, []
    for rank in range(7):
        layers = owned(old, rank)
        mine = order[everyone.start[layers.start] : everyone.start[layers.stop]]
        particles = Particles._make(array[[*mine, 0]] for array in p)  # room for one at least
        begins = everyone.start[layers.start : layers.stop + 1] - everyone.start[layers.start]
        slab = slab_of(old, rank)
        population = Population(particles, len(mine), shape, FRAME, slab, begins[: slab.layers + 1])
        planes = owned(old, rank, EXTRA)
        ranks.append((Comm(rank, boxes), population, [part[planes] for part in sums]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(redistribute, "_PIECE", piece)
        move = redistribute.redistribute
        jobs = [lambda r=rank: move(r[0], old, new, EXTRA, *r[1:]) for rank in ranks]
        results = together(jobs)

    for rank, (_, population, _) in enumerate(ranks):
        layers, planes = owned(new, rank), owned(new, rank, EXTRA)
        mine = order[everyone.start[layers.start] : everyone.start[layers.stop]]
        for all_rows, array in zip(p, population.up_to_date(), strict=True):
            assert array[population.order].tobytes() == all_rows[mine].tobytes()
        begins = everyone.start[layers.start : layers.stop + 1] - everyone.start[layers.start]
        assert population.start.tolist() == begins[: slab_of(new, rank).layers + 1].tolist()
        for got, part in zip(results[rank], sums, strict=True):
            assert got.shape == part[planes].shape and got.tobytes() == part[planes].tobytes()
        had = owned(old, rank)
        share = everyone.start[had.stop] - everyone.start[had.start]
        assert population._used <= share + len(mine)
        rows = population.insert(5)  # none that is in use
        assert not set(rows) & set(population.order) and len(set(rows)) == 5


# -- runs

SHARING = """
import os, subprocess, sys
import pgimp
from pgimp.mpi.comm import world
from pgimp.mpi.node import cores
from pgimp.solver.simulation import Simulation


if sys.argv[1] == "one":
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
sim = Simulation(pgimp.load(sys.argv[2]), world())
if sys.argv[1] == "one":
    # Work that is not the rank's, on the same core.
    busy = "from time import time; end = time() + 30; any(time() > end for _ in iter(int, 1))"
    other = subprocess.Popen([sys.executable, "-S", "-c", busy])
for step in range(60):
    sim.advance()
if sys.argv[1] == "one":
    other.kill()
rank = sim.rank
worked, took = ([times[key] for key in ("P2G", "G2P")] for times in (rank.worked, rank.timings))
mine = len(cores()), rank.worked is rank.timings, sum(worked), sum(took)
for line in world().gather(mine) or []:
    print(*line)
"""


def test_ranks_that_share_a_core_go_by_the_time_they_had_it(tmp_path, mpirun):
    """One core has two of them and other work: what these take is no work of a rank's."""
    write_case(tmp_path / "column.yaml", column(60, 5.5))
    for where in ("one", "all"):
        job = mpirun(2, ["-c", SHARING, where, tmp_path / "column.yaml"], 120)
        assert job.returncode == 0, job.stderr
        for line in job.stdout.splitlines():
            cores, same, worked, took = line.split()
            assert (same == "True") == (int(cores) >= 2)
            assert float(worked) <= 1.001 * float(took)
            if where == "one":  # a quarter if all had the same
                assert same == "False" and 0.0 < float(worked) < 0.7 * float(took)


PROBE = PROGRAMS / "balance_probe.py"
FOLLOWED = {"column": column(30, 5.5), "crossing": crossing(30, 6.0)}
#: Mirrors; outflow and space, with all of the grid, and probes; tractions, viscosity, constraints.
MORE = {
    "mirrored": SIZED["plane_finite"],
    "leaves": SCENES["plane_leaves"] | {"probes": PROBES},
    "space": SCENES["space_gimp"],
    "loaded": loaded(),
}
for name in ("leaves", "space"):
    MORE[name] = MORE[name] | {"output": MORE[name]["output"] | {"grid": GRID}}
SHUFFLED = ["column", *MORE]


@pytest.fixture(scope="module")
def runs(tmp_path_factory, mpirun, python):
    """``runs[how, ranks]`` is a folder of runs; more entries tell after which they went on."""
    folder = tmp_path_factory.mktemp("balance")
    cases = {name: folder / f"{name}.yaml" for name in FOLLOWED | MORE}
    for name, case in (FOLLOWED | MORE).items():
        write_case(cases[name], case)
    results = {}
    for start in (("off", 1), ("shuffled", 3), ("counted", 3), ("shuffled", 2, "shuffled", 3)):
        how, ranks, *before = start
        results[start] = folder / "-".join(map(str, start))
        if before:
            shutil.copytree(results[tuple(before)], results[start])
            for name in SHUFFLED:
                go_back(results[start] / name, 0.4)
        some = {"off": cases, "shuffled": SHUFFLED, "counted": FOLLOWED}[how]
        words = [PROBE, how, results[start], *(cases[name] for name in some)]
        job = python(words, 600) if ranks == 1 else mpirun(ranks, words, 600)
        assert job.returncode == 0, job.stderr
    return results


@pytest.mark.parametrize("start", [("shuffled", 3), ("shuffled", 2, "shuffled", 3)])
@pytest.mark.parametrize("name", SHUFFLED)
def test_no_bit_depends_on_where_boundaries_are(runs, name, start):
    """They go to random places every five steps, farther than a neighbour; also after a resume."""
    alone, moved = runs["off", 1], runs[start]
    assert (alone / name / "history.csv").read_text() == (moved / name / "history.csv").read_text()
    files = digests(alone / name)
    assert files == digests(moved / name)
    assert ("grid.xdmf" in files) == (name in ("mirrored", "leaves", "space"))
    assert set(files) >= {f"{probe}.csv" for probe in PROBES} or name != "leaves"
    assert len(start) == 2 or pgimp.open(moved / name).info["resumed_from"] > 0
    assert len(json.loads((moved / f"{name}.json").read_text())["moves"]) >= 5


@pytest.mark.parametrize("name", FOLLOWED)
def test_no_bit_depends_on_the_balance(runs, name):
    assert digests(runs["off", 1] / name) == digests(runs["counted", 3] / name)


@pytest.mark.parametrize("name", FOLLOWED)
def test_ranks_have_as_many_particles_as_each_other_all_the_time(runs, name):
    """Within a tenth, or what layers allow; and boundaries rest most of the time."""
    told, ranks = json.loads((runs["counted", 3] / f"{name}.json").read_text()), 3
    imbalance = np.array([max(now) * ranks / sum(now) - 1.0 for now in told["ranks"]])
    layers = [np.array(now) for now in told["layers"]]
    best = np.array([imbalance_of(now, cut(now, ranks, 2)) for now in layers])
    assert best.max() < 0.1
    assert (imbalance < 0.1 + 1e-9).all()
    assert 3 <= len(told["moves"]) < len(imbalance) / 4
    before, after = np.array(told["moves"]).T
    assert (after < before).all()


def test_without_it_they_would_not(runs):
    """The load leaves one of two ranks, or a good part of it does."""
    for name, least in (("column", 0.2), ("crossing", 1.0)):
        told = json.loads((runs["counted", 3] / f"{name}.json").read_text())
        first, last = np.array(told["layers"][0]), np.array(told["layers"][-1])
        assert imbalance_of(last, cut(first, 2, 2)) >= least


def test_the_log_tells_of_moves_and_of_the_imbalance(runs):
    alone, text = (runs[start] / "column" / "log.txt" for start in (("off", 1), ("counted", 3)))
    alone, text = alone.read_text(), text.read_text()
    moves = len(json.loads((runs["counted", 3] / "column.json").read_text())["moves"])
    assert re.search(rf"slab boundaries moved {moves} times: imbalance \d+ % before a move", text)
    assert re.search(r"^imbalance \d+ %: the busiest rank's P2G", text, re.MULTILINE)
    assert re.search(r"^balance +\d", text, re.MULTILINE)
    assert "slab boundaries" not in alone and "imbalance" not in alone


def test_a_rank_without_memory_for_a_move_ends_all(tmp_path, mpirun):
    write_case(tmp_path / "crossing.yaml", FOLLOWED["crossing"])
    job = mpirun(3, [PROBE, "short", tmp_path, tmp_path / "crossing.yaml"], 60)
    assert job.returncode == 1
    assert "pgimp: rank 1: out of memory: Unable to allocate 3 EiB" in job.stderr
    assert "Traceback" not in job.stderr
