"""Going on from a checkpoint: what is taken up, what may change, what is refused."""

import json
import shutil

import meshes
import meshio
import numpy as np
import pytest
from meshes import stl
from point_files import write_csv, write_hdf5
from resumed import EVERY, check_same, steps
from scenes import write_case

import pgimp
from pgimp.case.load import load
from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import UsageError
from pgimp.geometry.regions import REGIONS
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.mpi.comm import Serial
from pgimp.running.checkpoints import present

pytestmark = pytest.mark.slow(20)


def test_the_last_checkpoints_are_kept_and_the_end_has_one(whole):
    assert steps(whole) == [200, 160, 120]
    file = CheckpointFile(present(whole.path / "checkpoints")[0])
    assert file.count == 72 and file.about["frames"] == len(whole)
    np.testing.assert_array_equal(np.sort(file.read("id", 0, 72)), np.arange(72))


@pytest.mark.parametrize("back", [120, 160])
def test_a_resumed_run_leaves_the_same_files(run, whole, back):
    resumed = run(back=back)
    assert resumed.info["resumed_from"] == back and resumed.state == "done"
    check_same(whole, resumed)
    assert steps(resumed) == steps(whole)
    first, second = json.loads((resumed.path / "run.json").read_text())["starts"]
    assert (first["state"], second["state"]) == ("failed", "done")
    assert "ended without a word" in first["message"]


def test_a_run_that_goes_on_shows_its_steps(run):
    found = pgimp.open(run.output)
    history = run.output / "history.csv"
    history.write_text("".join(history.read_text().splitlines(keepends=True)[:4]) + "0.7,7")
    assert (found.info["steps"], found.info["time"]) == (60, 0.6)
    assert "running, 60 steps so far" in repr(found)
    history.unlink()
    assert "running, 200 steps so far" in repr(found)  # of the copied run.json
    with pytest.raises(UsageError, match=r"running or killed, begun .*, 0 steps"):
        run(resume=False)


def test_what_may_change_changes_no_particle(run, whole, capsys):
    changes = ["title=Another", "output={every: 0.1, fields: [stress]}", "history={every: 0.05}"]
    resumed = run(*changes, quiet=False)
    said = capsys.readouterr().out
    assert 'note: title is now Another, was "Two soft blocks"' in said
    assert "note: output is now {every: 0.1" in said and "note: time.end" not in said
    assert resumed.case.title == "Another"
    for field in resumed.frame(-1).fields:
        assert whole.frame(-1)[field].tobytes() == resumed.frame(-1)[field].tobytes()
    assert resumed.history["step"][-2:].tolist() == [195, 200]


def test_a_prolonged_run_has_the_bits_of_a_longer_one(run, folder):
    longer = pgimp.run(
        folder / "blocks.yaml",
        output=folder / "longer",
        overrides=["time.end=2.6", EVERY],
        quiet=True,
    )
    resumed = run("time.end=2.6", back=200)
    assert resumed.info["resumed_from"] == 200 and resumed.frame(-1).step == 260
    for field in longer.frame(-1).fields:
        assert longer.frame(-1)[field].tobytes() == resumed.frame(-1)[field].tobytes()


def test_another_case_is_refused_with_what_differs(run):
    before = {path: path.read_bytes() for path in run.output.rglob("*") if path.is_file()}
    with pytest.raises(UsageError) as error:
        run("materials.soft.young=200.0", "boundaries.y-max=fixed", "output.every=0.4", back=200)
    text = str(error.value)
    assert "  materials.soft.young is 200.0, was 100.0\n" in text
    assert "  boundaries.y-max is fixed, was slip\n" in text and "output.every" not in text
    assert "choose another directory with -o" in text
    after = {path: path.read_bytes() for path in run.output.rglob("*") if path.is_file()}
    assert after == before


def test_an_end_that_has_passed_is_refused(run):
    with pytest.raises(UsageError, match=r"time\.end: 1\.5 has passed, the run is at t = 1\.6"):
        run("time.end=1.5", "output.at=[]")


def test_an_end_within_the_run_leaves_no_trace_when_the_end_is_put_back(run, folder, tmp_path):
    """A line of the history at the step of a checkpoint, but written after it, goes again."""
    settings = ["history={every: {steps: 30}}", "checkpoint={every: {steps: 50}}", "output={}"]
    case = folder / "blocks.yaml"
    whole = pgimp.run(case, output=tmp_path / "other", overrides=settings, quiet=True)
    begun = [*settings, "time.end=1.2"]
    pgimp.run(case, output=tmp_path / "back", overrides=begun, quiet=True)
    (tmp_path / "back/checkpoints/step-000000120.h5").unlink()
    info = tmp_path / "back/run.json"
    info.write_text(info.read_text().replace('"done"', '"running"'))
    for end in (1.0, 2.0):
        changes = [*settings, f"time.end={end}"]
        back = pgimp.run(case, output=tmp_path / "back", overrides=changes, resume=True, quiet=True)
        assert back.info["resumed_from"] == 100
    assert whole.history["step"].tolist() == [0, 30, 60, 90, 120, 150, 180, 200]
    # The end at step 100 was one, so its line stays; no force is counted twice.
    assert back.history["step"].tolist() == [0, 30, 60, 90, 100, 120, 150, 180, 200]
    for name in ("x-min", "y-max"):
        force = f"reaction.{name}-{name[0]}"
        one, other = (np.diff(r.history["time"]) @ r.history[force][1:] for r in (whole, back))
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12)


def test_a_bundle_of_a_failure_goes_when_the_run_goes_on(run):
    (run.output / "failure").mkdir()
    (run.output / "failure" / "report.txt").write_text("old")
    run()
    assert not (run.output / "failure" / "report.txt").exists()


def test_what_a_checkpoint_takes_is_measured_and_kept(run, monkeypatch):
    from pgimp.running import checkpoints

    monkeypatch.setattr(checkpoints, "_SLOW", 1e-3)
    resumed = run()
    file = CheckpointFile(present(resumed.path / "checkpoints")[0])
    assert 0.0 < file.about["seconds"] < 10.0


def test_a_run_that_is_done_stays_as_it_is(folder, whole, capsys):
    before = {path: path.read_bytes() for path in whole.path.rglob("*") if path.is_file()}
    case = folder / "blocks.yaml"
    same = pgimp.run(case, output=whole.path, overrides=[EVERY], resume=True)
    assert "done already" in capsys.readouterr().out and same.state == "done"
    assert {path: path.read_bytes() for path in whole.path.rglob("*") if path.is_file()} == before


def test_another_version_or_processor_is_a_warning(run, whole, capsys, monkeypatch):
    from pgimp.io.rundir import runinfo

    monkeypatch.setattr(runinfo, "cpu", lambda: "another processor")
    resumed = run(quiet=False)
    said = capsys.readouterr().out
    assert "warning: the checkpoint was written with cpu" in said and "another processor" in said
    check_same(whole, resumed)


def test_checkpoints_by_simulated_time_by_wall_time_and_none(folder, tmp_path):
    def made(text):
        output = tmp_path / text[:12].strip("{").replace(":", "").replace(" ", "-")
        overrides = [f"checkpoint={{every: {text}, keep: 1000}}", "time.end=0.5", "output.at=[]"]
        return steps(pgimp.run(folder / "blocks.yaml", output=output, overrides=overrides))

    assert made("0.125") == [50, 38, 25, 13]
    assert made("null") == [50]
    assert len(made("{wall: 1.0e-9}")) == 50
    assert made("{wall: 900}") == [50]


def test_displacement_needs_the_initial_positions(tmp_path, folder):
    case, output = folder / "blocks.yaml", tmp_path / "run"
    few = ["output={fields: [stress]}", "checkpoint={every: {steps: 40}}"]
    pgimp.run(case, output=output, overrides=[*few, "time.end=1.0"], quiet=True)
    with pytest.raises(UsageError, match="displacement needs the initial positions"):
        pgimp.run(case, output=output, overrides=["checkpoint={every: 1.0}"], resume=True)


def test_a_state_is_what_the_simulation_goes_on_with(folder):
    """Taken out and put back at any step, also in the middle between two re-sorts."""
    from pgimp.solver.simulation import Simulation
    from pgimp.solver.state.state import capture

    class Memory:
        def __init__(self, sim):
            done = sim.now, sim.rate, sim.count, sim.diagnostic_sums
            state, rows, self._whole, _ = capture(sim.rank, *done, clock=sim.clock)
            self.about, self._rows = {"state": json.loads(json.dumps(state))}, dict(rows)
            self.count = sim.rank.count
            self.rows = {name: (a.dtype, a.shape[1:]) for name, a in self._rows.items()}
            self.whole = {name: (a.dtype, a.shape) for name, a in self._whole.items()}

        def read(self, name, first, last):
            return self._rows[name][first:last]

        def read_whole(self, name):
            return self._whole[name]

        def __eq__(self, other):
            arrays, others = self._rows | self._whole, other._rows | other._whole
            return self.about == other.about and all(
                arrays[name].tobytes() == others[name].tobytes() for name in {*arrays, *others}
            )

    case: Case = load(folder / "blocks.yaml")
    sim = Simulation(case, Serial())
    for step in range(1, 130):
        sim.advance()
        if step % 30 == 0:
            sim.diagnostics()
        if step in (1, 30, 47, 48, 49, 100):
            copy = Simulation(case, Serial(), Memory(sim))
            assert Memory(copy) == Memory(sim)
            started = step
    while copy.step < sim.step:
        copy.advance()
        if copy.step % 30 == 0:
            copy.diagnostics()
    assert started == 100 and Memory(copy) == Memory(sim)


def every_kind(D, folder):
    """Regions of each kind in the square from -2 to 2, by a name; files are in `folder`."""
    rng = np.random.default_rng(D)
    box = {"box": {"min": [-1.1] * D, "max": [0.9] * D}}
    ball = {"ball": {"centre": [0.1] * D, "radius": 1.2}}
    half = {"half-space": {"point": [0.2] * D, "normal": [1.0, 0.5, -0.3][:D]}}
    kinds = {
        "box": box,
        "ball": ball,
        "union": {"union": [box, ball]},
        "difference": {"difference": [ball, half]},
        "intersection": {"intersection": [box, half]},
    }
    data = {
        "position": rng.uniform(-1.5, 1.5, (40, D)),
        "volume": rng.uniform(0.02, 0.06, 40),
        "velocity": rng.uniform(-0.1, 0.1, (40, D)),
    }
    write_csv(folder / "cloud.csv", data)
    write_hdf5(folder / "cloud.h5", data)
    kinds |= {f"points-{end}": {"points": {"file": f"cloud.{end}"}} for end in ("csv", "h5")}
    if D == 3:
        stl(folder / "mesh.stl", meshes.ball(2))
        kinds["cylinder"] = {"cylinder": {"from": [-1, 0, 0.1], "to": [1, 0.5, 0], "radius": 0.9}}
    if D == 2:
        ring = np.array([[-1.0, -1.0], [1.1, -1.0], [0.8, 1.2]])
        cells = [("line", np.array([[0, 1], [1, 2], [2, 0]]))]
        meshio.write_points_cells(folder / "mesh.vtu", np.insert(ring, 2, 0.0, axis=1), cells)
    if D > 1:
        mesh = {"mesh": {"file": "mesh.stl" if D == 3 else "mesh.vtu"}}
        kinds |= {"mesh": mesh, "cut mesh": {"intersection": [mesh, half]}}
        np.save(folder / "heights.npy", rng.uniform(0.1, 0.9, (5,) * (D - 1)))
        nodes = {"origin": [-2.0] * (D - 1), "spacing": [1.0] * (D - 1)}
        kinds["heights"] = {"heights": {"file": "heights.npy", "bottom": -1.0, "nodes": nodes}}
    return kinds


@pytest.mark.parametrize("D", [1, 2, 3])
def test_a_body_of_every_kind_is_resumed_with_the_same_bits(tmp_path, D):
    """Also without the files that some of them came from."""
    kinds = every_kind(D, tmp_path)
    assert {"half-space", *(kind.partition("-")[0] for kind in kinds)} >= set(REGIONS) - (
        {1: {"mesh", "cylinder", "heights"}, 2: {"cylinder"}, 3: set()}[D]
    )
    for name, region in kinds.items():
        folder = tmp_path / name
        folder.mkdir()
        for end in ("csv", "h5", "stl", "vtu", "npy"):
            for file in tmp_path.glob(f"*.{end}"):
                shutil.copy(file, folder)
        model = meshes.case(region, dimension=D, end=0.04)
        write_case(folder / "case.yaml", model)
        words = {"quiet": True, "comm": Serial()}
        whole = pgimp.run(folder / "case.yaml", output=folder / "whole", **words)
        half = {"overrides": {"time.end": 0.02}, "output": folder / "half"}
        pgimp.run(folder / "case.yaml", **half, **words)
        for end in ("csv", "h5", "stl", "vtu", "npy"):
            for file in folder.glob(f"*.{end}"):
                file.unlink()
        resumed = pgimp.run(folder / "case.yaml", output=folder / "half", resume=True, **words)
        assert resumed.info["resumed_from"] == 2, name
        for field in whole.frame(-1).fields:
            assert whole.frame(-1)[field].tobytes() == resumed.frame(-1)[field].tobytes(), name


#: Older words for those that files have.
OLD = {
    "case.yaml": {"particles-per-cell": "particles_per_cell", "pic-damping": "relaxation",
                  "formulation: updated-lagrangian": "configuration: current",
                  "outflow": "escape", "wall-time": "wall", "body-force": "body_force",
                  "equilibrate": "settle"},
    "history.csv": {"overlap-mass.": "beyond."},
}  # fmt: skip


def age(path):
    """Put the older words into the files of a run."""
    for name, words in OLD.items():
        text = before = (path / name).read_text()
        for new, old in words.items():
            text = text.replace(new, old)
        assert text != before
        (path / name).write_text(text)


def test_an_older_run_goes_on_to_the_same_end(run, whole):
    age(run.output)
    resumed = run()
    assert resumed.info["resumed_from"] == 160
    check_same(whole, resumed)


def test_an_older_run_is_read(run, whole, capsys):
    age(run.output)
    old, new = pgimp.open(run.output), pgimp.open(whole.path)
    assert old.case == new.case
    assert old.history.dtype.names == new.history.dtype.names
    for name in ("beyond.x-min", "overlap-mass.x-min"):
        np.testing.assert_array_equal(old.history[name], new.history[name])
    figure = run.output / "curve.csv"
    columns = ["--columns", "beyond.*", "-o", str(figure)]
    assert main(["plot", str(run.output), str(whole.path), *columns]) == 0
    assert "run,time,overlap-mass.x-min," in figure.read_text()
    assert main(["compare", str(run.output), str(whole.path)]) == 0
    assert main(["report", str(run.output), "-o", str(run.output / "report.html")]) == 0
    page = (run.output / "report.html").read_text()
    assert "updated-lagrangian" in page and "beyond." not in page


def test_a_running_case_of_older_words_is_the_same_case(run, folder, whole):
    """What is compared at a resume are meanings, not words."""
    file = folder / "older.yaml"
    file.write_text(
        (folder / "blocks.yaml").read_text().replace("particles-per-cell", "particles_per_cell")
    )
    resumed = pgimp.run(file, output=run.output, overrides=[EVERY], quiet=True, resume=True)
    check_same(whole, resumed)
