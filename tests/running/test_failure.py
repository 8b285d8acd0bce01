"""What a run that particles stop leaves to look at, in its folder ``failure``."""

import re

import h5py
import numpy as np
import pytest
from paraview_reader import READERS, probe
from processes import PROGRAMS
from rank_probe import invert
from scenes import box, scene, start, write_case

import pgimp
from pgimp.errors import RunError
from pgimp.kernels.step.checks import INVERTED, NOT_FINITE
from pgimp.physics.derived import DERIVED, FITTED
from pgimp.physics.fields import EVERY
from pgimp.running import failure

#: Two squares far apart: on three ranks the first and the last one have a particle at fault each.
BODIES = {
    "left": box([1.0, 2.0], [5.0, 6.0], [0.1, 0.0]),
    "right": box([11.0, 2.0], [15.0, 6.0], [0.1, 0.2]),
}
CASE = scene(
    2, BODIES, cells=[16, 8], output={"every": 0.1, "fields": ["displacement"]},
    history={"every": {"steps": 1}},
)  # fmt: skip
IDS, STEP = "0,127", 25


def stopped(disturb, steps=STEP):
    """A simulation that has failed after `disturb` was done to it, and what it says."""
    sim = start(CASE)
    for _ in range(steps - 1):
        sim.advance()
    disturb(sim)
    with pytest.raises(RunError) as error:
        sim.advance()
    return sim, str(error.value)


def read(folder):
    with h5py.File(folder / "particles.h5") as file:
        return {name: file[name][:] for name in file if name != "VTKHDF"}, dict(file.attrs)


def around(sim, centres, radius):
    """Ids of the particles within a distance of places, in every direction, by the definition."""
    rows = sim.live()
    x = sim.particles.x[rows]
    near = np.zeros(len(rows), bool)
    for centre in centres:
        near |= (np.abs(x - centre) <= radius).all(axis=1)
    return set(sim.particles.id[rows[near]].tolist())


@pytest.fixture(scope="module")
def runs(tmp_path_factory, mpirun, python):
    """The jobs on one rank and on three, and their folder."""
    folder = tmp_path_factory.mktemp("failure")
    write_case(folder / "bad.yaml", CASE)
    script = PROGRAMS / "rank_probe.py"
    words = [script, "invert", IDS, STEP, "bad.yaml", "-o"]
    return folder, python([*words, "on-1"], cwd=folder), mpirun(3, [*words, "on-3"], cwd=folder)


def test_all_ranks_end_with_one_message_that_names_the_folder(runs):
    _, *jobs = runs
    for ranks, job in zip((1, 3), jobs, strict=True):
        assert job.returncode == 1 and "Traceback" not in job.stderr
        assert len(re.findall("^pgimp: ", job.stderr, re.MULTILINE)) == 1
        assert "particle 0 of body 'left' is turned inside out" in job.stderr
        assert "on rank 0; 1 other is at fault in the same step" in job.stderr
        assert f"on-{ranks}/failure shows the particles: report.txt, particles.xdmf" in job.stderr


def test_the_neighbourhood_is_all_within_three_cells(runs, tmp_path):
    sim, text = stopped(lambda sim: invert(sim, IDS))
    (tmp_path / "history.csv").write_text("time,step\n" + "".join(f"{i},{i}\n" for i in range(50)))
    for _ in range(2):  # the second replaces the first
        folder = failure.write(tmp_path, sim, text, tmp_path / "history.csv")
    assert folder == tmp_path / "failure"
    found, attributes = read(folder)
    p, ids = sim.particles, [int(i) for i in IDS.split(",")]
    row = {int(number): r for number, r in zip(p.id[sim.live()], sim.live(), strict=True)}
    wanted = around(sim, [p.x[row[i]] for i in ids], 3.0)
    assert found["id"].tolist() == sorted(wanted) and 40 < len(wanted) < sim.count - 20
    order = [row[i] for i in sorted(wanted)]
    assert found["fault"].tolist() == [INVERTED if i in ids else 0 for i in sorted(wanted)]
    # The same on any number of ranks.
    assert set(found) == {*EVERY, "connectivity"} - {"rank", "unwrapped", *DERIVED, *FITTED}
    np.testing.assert_array_equal(found["position"][:, :2], p.x[order])
    np.testing.assert_array_equal(found["stress"][:, :4], p.sigma[order])
    assert (found["radius"] > 0.0).all()
    assert attributes["step"] == STEP and attributes["time"] == pytest.approx(0.25)
    assert attributes["step"] == sim.step + 1

    report = (folder / "report.txt").read_text()
    assert report.startswith(f"{text}\n\n") and f"has {len(wanted)} particles" in report
    for number in ids:
        assert len(re.findall(rf"  particle {number} of body '\w+' is turned", report)) == 1
    dets = [float(value) for value in re.findall(r"det F: (\S+)", report)]
    np.testing.assert_allclose(dets, [np.linalg.det(p.F[row[i]].reshape(2, 2)) for i in ids])
    assert report.endswith("time,step\n" + "".join(f"{i},{i}\n" for i in range(30, 50)))
    assert 0.05 < float(re.search(r"Courant number of (\S+)", report)[1]) < 0.2

    # The runs have left the same, whatever the ranks.
    for ranks in (1, 3):
        left = runs[0] / f"on-{ranks}" / "failure"
        assert sorted(path.name for path in left.iterdir()) == sorted(
            ["particles.h5", "particles.xdmf", "report.txt"]
        )
        for name in ("particles.h5", "particles.xdmf"):
            assert (left / name).read_bytes() == (folder / name).read_bytes()
        # The run has a history of its own, and may tell more on top.
        told = (left / "report.txt").read_text().partition("The last lines")
        assert told[0] == report.partition("The last lines")[0]
        lines = (runs[0] / f"on-{ranks}" / "history.csv").read_text().splitlines()
        assert told[2].splitlines()[1:] == [lines[0], *lines[-20:]]


def test_what_others_learn_a_step_late_is_told_alike(tmp_path, mpirun, python):
    """Particles at fault in the slabs' ends, in between, and where lists of them overflow."""
    bar = scene(2, box([1.0, 1.0], [31.0, 11.0]), cells=[32, 12], per_cell=4, end=1.0,
                output={"every": 1.0}, history={"every": 1.0})  # fmt: skip
    write_case(tmp_path / "bad.yaml", bar)
    script = PROGRAMS / "rank_probe.py"
    left = []
    for ids in ("2000,700,40,4700", ",".join(map(str, range(150, 4000)))):
        for ranks, start_on in ((1, python), (2, lambda words, cwd: mpirun(2, words, cwd=cwd))):
            output = f"on-{ranks}-{len(left)}"
            job = start_on([script, "invert", ids, 26, "bad.yaml", "-o", output], cwd=tmp_path)
            assert job.returncode == 1 and "Traceback" not in job.stderr
            text = re.sub(r"on rank \d", "", job.stderr.replace(output, ""))
            files = {
                path.name: path.read_bytes() for path in (tmp_path / output / "failure").iterdir()
            }
            report = files.pop("report.txt").decode()
            files["report"] = re.sub(r"on rank \d", "", report).encode()
            left.append((re.sub(r".*\[.*\n", "", text), files))
            run = pgimp.open(tmp_path / output)
            assert (run.info["steps"], list(run.times), list(run.history["step"])) == (25, [0], [0])
    assert "particle 40 of body" in left[0][0] and "3 others are at fault" in left[0][0]
    assert "particle 150 of body" in left[2][0] and "3849 others are at fault" in left[2][0]
    assert left[0][1] == left[1][1] and left[2][1]["report"] == left[3][1]["report"]


def test_what_is_at_infinity_is_drawn_where_it_was(tmp_path, pvpython):
    """ParaView shows the bundle; positions, sizes and the numbers that colour it are there."""

    def fling(sim):
        p = sim.particles
        p.v[sim.live()[p.id[sim.live()] == 9]] = np.inf

    sim, text = stopped(fling, 3)
    assert "not a finite number" in text and sim.rank.failed > 8
    rows = sim.rank.errors[: sim.rank.failed, 0]
    assert not np.isfinite(sim.particles.x[rows]).all()
    assert (sim.rank.errors[: sim.rank.failed, 1] == NOT_FINITE).all()
    folder = failure.write(tmp_path, sim, text, tmp_path / "none.csv")
    found, _ = read(folder)
    start_of = start(CASE)
    before = {int(i): x for i, x in zip(start_of.particles.id, start_of.particles.x, strict=True)}
    assert np.isfinite(found["position"]).all() and (found["radius"] > 0.0).all()
    for number, place, fault in zip(found["id"], found["position"], found["fault"], strict=True):
        assert np.abs(place[:2] - before[int(number)]).max() < (0.6 if fault else 0.01)
    assert set(found["id"][found["fault"] > 0]) == set(sim.particles.id[rows])
    assert "none.csv:\n(cannot be read" in (folder / "report.txt").read_text()
    shown = probe(pvpython, folder / "particles.xdmf", 0)
    for reader in READERS:
        (only,) = shown[reader]["shown"]
        assert only["cells"] == len(found["id"])
        np.testing.assert_array_equal(only["arrays"]["points"], found["position"])
        np.testing.assert_array_equal(np.ravel(only["arrays"]["fault"]), found["fault"])


def test_the_neighbourhood_stays_small(tmp_path, monkeypatch):
    sim, text = stopped(lambda sim: invert(sim, "9,10,117"), 2)
    monkeypatch.setattr(failure, "_MOST_NEIGHBOURS", 30)
    monkeypatch.setattr(failure, "_MOST_CENTRES", 2)
    monkeypatch.setattr(failure, "_MOST_FAULTS", 2)
    found, _ = read(failure.write(tmp_path, sim, text, tmp_path / "none.csv"))
    p, rows = sim.particles, sim.rank.errors[:2, 0]
    inside = {r: around(sim, p.x[rows], r) - {9, 10} for r in failure.RADII}
    radius = max(r for r, ids in inside.items() if len(ids) <= 30)
    assert 0.5 < radius < 3.0 and set(found["id"].tolist()) == inside[radius] | {9, 10}
    assert f"within {radius:g} cells" in " ".join(
        (tmp_path / "failure" / "report.txt").read_text().split()
    )


def test_the_error_is_told_where_the_folder_cannot_be_written(tmp_path):
    sim, text = stopped(lambda sim: invert(sim, IDS), 2)
    (tmp_path / "failure").write_text("in the way")
    assert failure.write(tmp_path, sim, text, tmp_path / "none.csv") is None
    assert (tmp_path / "failure").read_text() == "in the way"
    assert failure.write(tmp_path / "gone", sim, text, tmp_path / "none.csv") is None
    assert failure.write(tmp_path, start(CASE), text, tmp_path / "none.csv") is None


@pytest.mark.parametrize(
    ("volumetric", "courant", "limit", "short"),
    [
        ("pointwise", 0.42, 0.45, True),
        ("pointwise", 0.55, 0.45, False),
        ("pointwise", "auto", 0.59, True),
        # As the warning before the run says: without nearly incompressible bodies as without it.
        ("mean", 0.42, 0.45, True),
    ],
)
def test_a_step_is_called_too_long_where_it_was(tmp_path, volumetric, courant, limit, short):
    case = CASE | {
        "method": CASE["method"] | {"volumetric": volumetric},
        "time": {"end": 1.0, "step": {"courant": courant}},
    }
    sim = start(case)
    sim.advance()
    invert(sim, IDS)
    with pytest.raises(RunError) as error:
        sim.advance()
    folder = failure.write(tmp_path, sim, str(error.value), tmp_path / "none.csv")
    report = " ".join((folder / "report.txt").read_text().split())
    assert f"gimp is stable up to {limit:g}." in report
    assert ("So the step was short enough" in report) == short
    assert ("That is too much" in report) != short
