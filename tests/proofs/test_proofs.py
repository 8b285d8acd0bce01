"""The proofs of scripts/faults, in short: they hold, and print their figures."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from outside_materials import SOFTENING, registered
from processes import run
from proofs import proof_scenes
from proofs.scenes import books as scene_books
from proofs.scenes import features as scene_features
from proofs.scenes import shrink as scene_shrink
from proofs.scenes.bodies import REGIONS
from proofs.scenes.runs import FUNCTIONS
from scenes import box, scene, start, wall

import pgimp
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

PROOFS = Path(__file__).resolve().parents[2] / "scripts" / "proofs"

pytestmark = pytest.mark.slow(200)


def prove(*words, timeout=600):
    job = run([sys.executable, str(PROOFS), *words], timeout)
    assert job.returncode == 0, job.stdout + job.stderr
    return job.stdout


def test_killed_runs_go_on_to_the_same_bits():
    said = prove("kill", "--short", "--runs", "3", "--seed", "1")
    assert "same bits as the undisturbed run: 3 of 3" in said
    assert re.search(r"killed: .*start-up", said) and re.search(r"killed: .*checkpoint", said)
    # mpirun gives the other ranks two seconds, and it is alone on no machine.
    assert float(re.search(r"end of the job: .* most ([\d.]+) s", said)[1]) < 15.0


def test_runs_stop_on_every_signal_and_go_on_to_the_same_bits():
    said = prove("signals", "--short", "--runs", "6", "--seed", "2")
    same = re.findall(r"(\d+) (status \d+)[^,]*(?:, within[^,]*)?, same bits", said)
    assert sum(int(count) for count, _ in same) == 6, said
    assert sum(int(count) for count, what in same if what == "status 75") >= 2, said


def test_damaged_checkpoints_are_skipped_or_refused():
    said = prove("checkpoints", "--runs", "56")
    assert "42 newest damaged: skipped, same bits, 14 all damaged: status 1" in said


def test_many_steps_leave_no_trace_in_the_memory():
    said = prove("long", "--quick")
    assert said.count("mass: 1 value(s)") == 2
    for residual in re.findall(r"is at most ([\d.e+-]+) of", said):
        assert float(residual) < 1e-8  # rounding of as many steps


@pytest.mark.wide
def test_contact_that_keeps_its_selections_has_the_bits_of_one_that_does_not():
    """Blocks between walls, for a hundredth of the steps."""
    said = prove("kept", "--quick", "--scene", "blocks")
    selections, anew = map(int, re.search(r"(\d+) selections, (\d+) anew", said).groups())
    assert selections < anew / 2


@pytest.mark.wide
def test_random_scenes_are_the_same_on_any_ranks_and_their_books_balance():
    """Six; a failing one is printed as a case file, made smaller."""
    numbers = [(proof_scenes.GROUP * group + n, group) for group in proof_scenes.SHORT
               for n in range(2)]  # fmt: skip
    scenes = [scene_features.make(1, *each) for each in numbers]
    seen = {feature for *_, features in scenes for feature in features}
    kinds = {
        "affine", "relaxation", "constraint", "walls", "gravity", "probes", "free body", "contact",
        "initial configuration", "mean dilatation", "mirrors", "metals", "flows", "variation",
        "stages",
    }  # fmt: skip
    assert kinds <= seen
    cases = [case for case, *_ in scenes]
    assert {case["dimensions"] for case in cases} == {1, 2, 3}
    assert {case["method"]["shape"] for case in cases} >= {"mpm", "gimp"}
    assert {case["dimensions"] for case in cases if "points" in json.dumps(case)} >= {1, 2}
    for kind in ("boundaries", "constraints"):  # accelerated ones, and gravity where one is held
        assert any("table" in json.dumps(case.get(kind, {})) for case in cases)
        assert any(case.get(kind) and "gravity" in case for case in cases)
    said = prove("scenes", "--short", "--runs", "6", "--shrink", "60", timeout=1200)
    assert int(re.search(r"(\d+) done", said)[1]) == 6 and "wrong: 0" in said


@pytest.mark.wide
def test_bodies_that_meet_by_surfaces_keep_depth_momenta_energy_and_bits():
    """Rings, a seam on which a body lies, and restitution are among them."""
    said = prove("surfaces", "--short", "--runs", "3", timeout=1200)
    assert "{'done': 3}" in said


@pytest.mark.wide
def test_heaps_go_on_to_the_same_bits():
    said = prove("heaps", "--short", "--runs", "2", timeout=1200)
    assert "{'the same bits': 2}" in said and said.count(" at ") >= 4
    assert "drum" in said and "initial" in said


def books_of_a_push(axis, kind):
    """A block that stands on an accelerated wall, or whose half is held so, along an axis."""
    velocity = [0.0, 0.0]
    velocity[axis] = {"table": [[0.0, 0.0], [0.1, 2.0], [0.2, -2.0]]}
    low, high = [2.0, 2.0], [5.0, 5.0]
    low[axis], high[axis] = 0.0, 4.0
    if kind == "boundaries":
        parts = {kind: {f"{'xy'[axis]}-min": {"velocity": velocity}}}
    else:
        region = {"box": {"min": low, "max": [3.5, 3.5]}}
        parts = {kind: {"grip": {"body": "body", "region": region, "velocity": velocity}}}
    case = scene(2, box(low, high), end=0.2, **parts)
    books = scene_books.Books(Simulation(pgimp.load(case), Serial()))
    books.run()
    assert not books.wrong
    return books


def test_books_know_the_way_of_a_constraint_that_a_force_moves():
    region = {"box": {"min": [2.0, 2.0], "max": [3.5, 3.5]}}
    grip = {"body": "body", "region": region, "force": [9.0, None], "velocity": [None, 0.1]}
    case = scene(2, box([2.0, 2.0], [5.0, 5.0]), end=0.2, constraints={"grip": grip})
    books = scene_books.Books(Simulation(pgimp.load(case), Serial()))
    books.run()
    assert not books.wrong and len(books._work) == 21
    assert books._lines[-1]["external-work"] > 0.1


@pytest.mark.parametrize("kind", ["boundaries", "constraints"])
@pytest.mark.filterwarnings("error")
def test_books_know_what_accelerated_walls_make_along_each_axis(kind):
    one, other = (books_of_a_push(axis, kind) for axis in (0, 1))
    explained = [books._explained[-1] for books in (one, other)]
    assert explained[0] == pytest.approx(explained[1], rel=1e-6)
    assert abs(explained[0]) > 1e-4 * max(line["kinetic-energy"] for line in one._lines)


FLIPPED = """
import json, random, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from proofs.scenes import features as scene_features, runs as scene_runs
scene_runs.prepare()
from pgimp.decomposition import redistribute

unpack = redistribute.unpack
def flipped(records, particles, rows):
    unpack(records, particles, rows)
    particles.v[rows[:1], 0] *= 1.0 + 3e-16
if sys.argv[2] == "flipped":
    redistribute.unpack = flipped
case, files, _ = scene_features.make(1, 19001, 950)
for name, text in (files | {"case.yaml": json.dumps(case)}).items():
    Path(name).write_text(text)
print(scene_runs.compare(Path("case.yaml"), Path("runs"), random.Random(3), 30))
"""


@pytest.mark.parametrize("how", ["flipped", pytest.param("sound", marks=pytest.mark.wide)])
def test_one_bit_of_one_particle_that_changes_rank_is_noticed(tmp_path, how):
    job = run([sys.executable, "-c", FLIPPED, str(PROOFS.parent), how], 300, cwd=tmp_path)
    assert job.returncode == 0, job.stderr
    assert ("frames, history.csv" in job.stdout) == (how == "flipped"), job.stdout
    assert "kind='done'" in job.stdout


PAST = """
import sys
sys.path.insert(0, sys.argv[1])
from proofs import bounds
import numpy as np
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.rows import Solved
from pgimp.kernels.contact.impulses.warm_start import KEPT_FORCE, keep_impulses

pairs, none = ContactPairs.empty(1), np.empty(0, KEPT_FORCE)
pairs.states["normal_impulse"] = pairs.states["normal"] = 1.0
coupling = Coupling.empty(2, 1)
keep_impulses(pairs, coupling, Solved.empty(1, coupling), np.zeros((1, 8)), 1.0, none, none)
"""


def test_an_index_past_the_end_is_noticed_with_bounds(tmp_path):
    env = {"FAULTS_BOUNDS": "1", "XDG_CACHE_HOME": str(tmp_path)}
    job = run([sys.executable, "-c", PAST, str(PROOFS.parent)], env=env)
    assert "IndexError" in job.stderr and list(tmp_path.glob("pgimp-bounds/kernels-*/*"))


@pytest.fixture
def softening():
    with registered(SOFTENING, FUNCTIONS) as (module, _):
        yield module


def test_random_scenes_are_good_cases_of_every_kind(tmp_path, monkeypatch, softening):
    monkeypatch.chdir(tmp_path)
    refused, seen = 0, set()
    for number in range(300):
        case, files, features = scene_features.make(4, number, number // 2)
        for name, text in files.items():
            (tmp_path / name).write_text(text)
        try:
            pgimp.load(case)
        except CaseError:
            refused += 1
        seen |= {case["dimensions"], case["method"]["shape"], *features}
        regions = json.dumps([body["region"] for body in case["bodies"].values()])
        seen |= {kind for kind in REGIONS if f'"{kind}"' in regions}
        seen |= {str(each) for each in case["boundaries"].values()}
    assert refused <= 3
    features = {feature.name for feature in scene_features.FEATURES}
    walls = set(scene_features.WALLS) - {"moving"}
    assert {1, 2, 3, *scene_features.SHAPES, *REGIONS, *features, *walls} <= seen


def test_a_scene_is_the_same_again_whatever_features_there_are_besides(monkeypatch):
    """So that a seed still makes the scene that failed."""
    before = [scene_features.make(1, number, 2)[0] for number in range(10)]
    kept = [feature for feature in scene_features.FEATURES if feature.name != "gravity"]
    monkeypatch.setattr(scene_features, "FEATURES", kept)
    after = [scene_features.make(1, number, 2)[0] for number in range(10)]
    assert before != after
    for case in before:
        case.pop("gravity", None)
    assert before == after


@pytest.mark.wide
def test_a_failing_scene_is_made_smaller():
    """What it fails of stays: a difference of regions, in a case that can be run."""

    def fails(case):
        try:
            pgimp.load(case)
        except CaseError:
            return False
        return '"difference"' in json.dumps(case["bodies"])

    every = (scene_features.make(2, number, number)[0] for number in range(100))
    found = [scene_shrink.shrink(case, fails, 60.0) for case in every if fails(case)][:8]
    assert len(found) == 8
    for case in found:
        assert fails(case) and case["dimensions"] <= 2 and len(case["bodies"]) == 1
        optional = ("gravity", "contact", "probes", "tractions", "constraints", "boundaries")
        assert not any(case.get(key) for key in (*optional, "outflow"))
        assert case["time"]["end"] == case["time"]["step"]


@pytest.mark.parametrize("words", [["nothing"], ["kill", "--runs", "many"]])
def test_wrong_words_are_answered(words):
    job = run([sys.executable, str(PROOFS), *words])
    assert job.returncode != 0 and "Traceback" not in job.stderr


@pytest.mark.parametrize("affine", [True, pytest.param(False, marks=pytest.mark.wide)])
def test_books_close_while_the_window_of_the_grid_grows(affine):
    """What they see of the vertices belongs to the step; after it the window may be another.

    A block of two cells, whose energy grows by an eighth with `affine`, flies through the grid;
    what affine makes is counted. Without the option only the step's length makes energy.
    """
    step = {"courant": 0.05}
    case = scene(2, box([1.2, 1.3], [3.2, 3.3], [0.0, 0.6]), cells=[8, 12], end=8.0, step=step)
    case["method"]["affine"] = affine
    case["boundaries"] = {"x-min": wall([[0.0, 0.0], [8.0, 0.1]], None)}
    sim = start(case)
    p, rows = sim.particles, sim.live()
    stretch = 0.5 * (p.x[rows] - p.x[rows].mean(axis=0))
    p.v[rows] += stretch
    if affine:
        p.L[rows] = 0.5 * np.eye(2).reshape(-1)
    window = sim.rank.grid.window
    books = scene_books.Books(sim)
    books.run()
    assert sim.rank.grid.window != window
    assert not books.wrong
    assert books.created < 0.02
