"""Whole runs give the same bits on any number of ranks: every frame, and every line of history."""

import re
import shutil

import numpy as np
import pytest
from processes import PROGRAMS
from rank_scenes import EXACT, SCENES
from run_files import digests, go_back
from scenes import write_case

import pgimp

pytestmark = pytest.mark.slow(400)

#: With five there are slabs at both ends, slabs between two others, empty ones, the thinnest there
#: are, and ranks that own none: see the tests of the scenes.
RANKS = (1, 3, 5)
#: Runs that are resumed: on how many ranks they began, on how many and where they go on.
RESUMED = {(3, 2): 0.2, (5, 4): 0.5}
#: Of which scenes: each dimension, shapes whose size follows the deformation, mirrors, Courant
#: control, all loads, probes and frames of the grid, particles that leave, and those that carry
#: gradients. A checkpoint of the others holds nothing else. What is in one does not depend on
#: ranks, nor who reads which part of it on the scene: each scene goes on in one of the two ways,
#: and in each way some of every dimension, some with mirrors, and some that lose particles.
GO_ON = {
    (3, 2): (
        "line_leaves",
        "line_slows",
        "plane_gimp",
        "plane_fuzzy",
        "affine",
        "loaded",
        "narrow",
        "layer",
        "pours",
        "sinks",
        "soaked",
    ),
    (5, 4): (
        "line_mpm",
        "plane_leaves",
        "meeting",
        "phased",
        "staged",
        "flowing",
        "plane_mirror",
        "space_finite",
        "narrow",
        "initial",
        "exact_surfaces",
        "exact_contact",
        "exact_means",
        "exact_round",
        "exact_rings",
        "exact_skins",
        "initial_stages",
        "initial_contact",
        "surface_contact",
        "surface_beside",
        "surface_boxes",
        "surface_stages",
        "surface_blocks",
        "surface_folded",
        "surface_rings",
        "surface_round",
        "mixed_rings",
        "mixed_round",
        "mixed_flows",
        "initial_lattice",
        "averaged_lattice",
        "averaged_contact",
        "averaged_layers",
        "averaged_grip",
        "averaged_surfaces",
        "both_configurations",
        "damped",
        "settled",
        "quaking",
        "dug",
        "pressed",
        "varied",
        "round_and_round",
        "rigid_round",
        "rings_free",
        "endless",
        "lifts",
        "streams",
        "turned",
        "passing",
    ),
}
#: Each dimension, both kinds of contact, walls, seams, stages, damping: other scenes are wide.
CORE = (
    "line_gimp",
    "line_slows",
    "line_mpm",
    "line_leaves",
    "plane_gimp",
    "plane_mpm",
    "plane_finite",
    "plane_leaves",
    "space_gimp",
    "other_output",
    "narrow",
    "metals",
    "meeting",
    "phased",
    "staged",
    "round_and_round",
    "exact_surfaces",
    "exact_contact",
    "exact_means",
    "exact_round",
    "initial_contact",
    "surface_contact",
    "surface_boxes",
    "initial_lattice",
    "averaged_lattice",
    "averaged_surfaces",
    "damped",
    "quaking",
    "ring",
    "passing",
)


def of(name, *more):
    """Parameters with a scene, wide if it is none of the core."""
    return pytest.param(name, *more, marks=[] if name in CORE else [pytest.mark.wide])


#: Scenes that run on three ranks too: those that go on from there, and those that tests look at.
#: Five ranks have all kinds of slabs that three have.
ON_THREE = (*GO_ON[3, 2], "line_gimp", "line_fuzzy", "other_output")
#: On 4 ranks messages go as between machines, otherwise through shared memory.
TCP = {"OMPI_MCA_btl": "tcp,self", "OMPI_MCA_btl_tcp_if_include": "lo"}


@pytest.fixture(scope="module")
def runs(tmp_path_factory, mpirun, python, request):
    """``runs[ranks]`` is the folder with that many ranks' runs of the scenes, by name."""
    folder = tmp_path_factory.mktemp("ranks")
    names = SCENES if request.config.option.all else CORE
    cases = [folder / f"{name}.yaml" for name in names]
    for path in cases:
        write_case(path, SCENES[path.stem])
    results = {}
    for start in (*RANKS, *RESUMED):
        before, ranks = start if isinstance(start, tuple) else (0, start)
        results[start] = folder / f"on-{ranks}-after-{before}"
        some = [path for path in cases if ranks != 3 or path.stem in ON_THREE]
        if before:
            some = [path for path in cases if path.stem in GO_ON[start]]
            for path in some:
                shutil.copytree(results[before] / path.stem, results[start] / path.stem)
                go_back(results[start] / path.stem, RESUMED[start])
        words = [PROGRAMS / "rank_probe.py", "runs", results[start], *some]
        env = TCP if ranks == 4 else None
        job = python(words, 2400) if ranks == 1 else mpirun(ranks, words, 2400, env=env)
        assert job.returncode == 0, job.stderr
    return results


@pytest.mark.parametrize(
    ("name", "ranks"), [*(of(name, 3) for name in ON_THREE), *(of(name, 5) for name in SCENES)]
)
def test_frames_and_history_are_the_same_bytes(runs, name, ranks):
    alone, together = runs[1] / name, runs[ranks] / name
    assert pgimp.open(together).info["ranks"] == ranks
    # First what is easier to understand when it fails.
    for mine, theirs in zip(pgimp.open(alone), pgimp.open(together), strict=True):
        assert (mine.time, mine.step) == (theirs.time, theirs.step)
        for field in mine.fields:
            one, other = mine[field], theirs[field]  # nan where a material has no such state
            same = np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
            assert same, (mine.number, field)
    assert (alone / "history.csv").read_text() == (together / "history.csv").read_text()
    assert digests(alone) == digests(together)


@pytest.mark.parametrize(
    ("name", "start"), [of(name, start) for start, names in GO_ON.items() for name in names],
    ids=lambda each: each if isinstance(each, str) else "{}-then-{}".format(*each),
)  # fmt: skip
def test_resumed_runs_leave_the_same_bytes(runs, name, start):
    alone, resumed = runs[1] / name, runs[start] / name
    assert pgimp.open(resumed).info["ranks"] == start[1]
    assert pgimp.open(resumed).info["resumed_from"] >= 23
    for name in ("history.csv", "particles.xdmf", "particles.vtkhdf"):
        assert (alone / name).read_bytes() == (resumed / name).read_bytes()
    assert digests(alone) == digests(resumed)


@pytest.mark.parametrize("name", [*map(of, EXACT)])
def test_exact_solutions_have_errors(runs, name):
    history = pgimp.open(runs[5] / name).history
    assert (history["error.displacement-l2"][1:] > 0.0).all()


def reach(frame, axis, body=None):
    """Least and greatest coordinate of the particles, or of a body's."""
    rows = slice(None) if body is None else frame["body"] == frame.bodies.index(body)
    x = frame["position"][rows, axis]
    return x.min(), x.max()


@pytest.mark.parametrize(
    ("name", "body"),
    [
        of("line_gimp", "quick"),
        of("plane_gimp", "flies"),
        of("plane_mpm", "up"),
        of("plane_mpm", "down"),
        of("space_gimp", "flies"),
        of("space_mpm", "flies"),
    ],
)
def test_the_scenes_cross_slabs(runs, name, body):
    """A body that leaves the place where it was leaves the slabs that shared it out."""
    first, *_, last = pgimp.open(runs[1] / name)
    (low, high), (new_low, new_high) = reach(first, 0, body), reach(last, 0, body)
    assert new_low > high or new_high < low
    rows = last["body"] == last.bodies.index(body)
    assert np.abs(last["stress"][rows]).max() > 1e-3  # and something happens


def test_the_scenes_leave_slabs_empty(runs):
    """A third of the particles are below x = 5 at the start, so is at least one slab of 5."""
    first, *_, last = pgimp.open(runs[1] / "line_gimp")
    assert (first["position"][:, 0] < 5.0).mean() >= 1 / 3
    assert last["position"][:, 0].min() > 7.0


@pytest.mark.parametrize(
    ("name", "axes"),
    [of("plane_gimp", [1]), of("plane_mpm", [1]), of("space_gimp", [1, 2]),
     of("space_mpm", [1, 2]), of("narrow", [1])],
)  # fmt: skip
def test_the_scenes_outgrow_the_window_of_the_start(runs, name, axes):
    """By more than the margin of 2 cells that the stored planes have."""
    first, *_, last = pgimp.open(runs[1] / name)
    for axis in axes:
        (low, high), (new_low, new_high) = reach(first, axis), reach(last, axis)
        assert new_high > high + 2.0 or new_low < low - 2.0


@pytest.mark.wide
def test_the_log_counts_held_half_widths_over_all_ranks(runs):
    """Tents of a whole cell, of which a blow stretches some in some steps."""
    said = []
    for ranks in RANKS:
        text = " ".join((runs[ranks] / "line_fuzzy" / "log.txt").read_text().split())
        said += re.findall(r"in (\d+) particle-steps [(](\S+) %[)] a particle was stretched", text)
        assert "was stretched" not in (runs[ranks] / "line_gimp" / "log.txt").read_text()
    assert len(said) == len(RANKS) and len(set(said)) == 1
    steps = pgimp.open(runs[1] / "line_fuzzy").info["steps"]
    assert 0 < int(said[0][0]) < 24 * steps
    assert float(said[0][1]) == pytest.approx(100 * int(said[0][0]) / (24 * steps), rel=0.05)


def test_surplus_ranks_are_idle(runs):
    texts = {}
    for start, folder in runs.items():
        texts[start] = " ".join((folder / "narrow" / "log.txt").read_text().split())
    assert "1 of 5 ranks own no layer" in texts[5]
    assert texts[5, 4].count("own no layer") == 1  # of its beginning
    for start in (3, (3, 2)):
        assert "own no layer" not in texts[start]


def test_rows_were_sorted_anew_and_steps_followed_the_speed(runs):
    for name in ("line_gimp", "plane_mpm"):
        assert pgimp.open(runs[1] / name).info["steps"] > 128
    for name in ("line_mpm", "plane_gimp", "space_gimp"):
        dt = pgimp.open(runs[1] / name).history["dt"][1:]
        assert len(np.unique(dt)) > 5


def test_steps_lengthen_after_a_run_goes_on(runs):
    """It goes on in the middle of a window: checkpoints come every 23 steps, windows have 64."""
    run = pgimp.open(runs[3, 2] / "line_slows")
    dt, step = run.history["dt"][1:], run.history["step"][1:]
    longer = step[1:][np.diff(dt) > 0.02 * dt[:-1]]
    assert 64 < run.info["resumed_from"] < longer[0] <= longer[-1]
    for folder in runs.values():
        if (folder / "line_slows").exists():
            log = (folder / "line_slows" / "log.txt").read_text()
            # Once by each process: by one that was stopped, and by that which went on.
            assert 1 <= log.count("steps could have been longer by 5 % or more") <= 2


@pytest.mark.parametrize("ranks", RANKS)
def test_other_output_gives_the_same_particles(runs, ranks):
    one, other = pgimp.open(runs[1] / "plane_gimp"), pgimp.open(runs[ranks] / "other_output")
    assert len(other) > len(one) and other.frames[-1].fields != one.frames[-1].fields
    assert one.info["steps"] == other.info["steps"]
    both = {frame.step: frame for frame in other}
    shared = [frame for frame in one if frame.step in both]
    assert len(shared) >= 3
    for frame in shared:
        for field in ("id", "position", "volume", "velocity"):
            assert np.array_equal(frame[field], both[frame.step][field])


def test_the_command_line_gives_the_same_bytes(runs, mpirun):
    job = mpirun(3, ["-m", "pgimp", "line_gimp.yaml", "-o", "cli"], cwd=runs[1].parent)
    assert job.returncode == 0, job.stderr
    assert re.search(r"24 particles in 1D on 3 ranks", " ".join(job.stdout.split()))
    assert digests(runs[1].parent / "cli") == digests(runs[1] / "line_gimp")
