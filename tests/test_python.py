"""pgimp from Python: cases changed, run in loops and step by step, results read and handed on."""

import csv
import os
import signal
import sys
import threading
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from processes import run as start
from scenes import write_case
from small_block import BLOCK

import pgimp
from pgimp.errors import CaseError, RunError, UsageError

CASES = Path(__file__).resolve().parents[1] / "cases"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the run of the block on one rank in ``run``."""
    folder = tmp_path_factory.mktemp("python")
    write_case(folder / "block.yaml", BLOCK)
    pgimp.run(BLOCK, output=folder / "run", quiet=True)
    return folder


@pytest.fixture
def run(folder):
    """The run, opened."""
    return pgimp.open(folder / "run")


def lines_of(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def content(run, number):
    """What is in a frame's file, by h5py alone."""
    with h5py.File(run.path / f"frames/particles-{number:06d}.h5") as file:
        return {name: file[name][()] for name in file if name != "VTKHDF"}


def test_history_and_probes_are_what_the_files_hold(run):
    for path, table in [
        (run.path / "history.csv", run.history),
        (run.path / "probes/tip.csv", run.probes["tip"]),
    ]:
        lines = lines_of(path)
        assert len(lines) > 3 and list(table.dtype.names) == list(lines[0])
        frame = table.to_pandas()
        assert list(frame.columns) == list(lines[0])
        for name in lines[0]:
            expected = [float(line[name]) for line in lines]
            np.testing.assert_array_equal(table[name], expected)
            np.testing.assert_array_equal(frame[name], expected)
    with pytest.raises(KeyError):
        run.probes["top"]


def test_frames_are_what_the_files_hold(run):
    assert len(run) == 3 and [frame.number for frame in run] == [0, 1, 2]
    np.testing.assert_allclose(run.times, [0.0, 0.1, 0.2], rtol=1e-12)
    for frame in run:
        file = content(run, frame.number)
        assert set(frame) == set(file) - {"connectivity"} and "stress" in frame
        for name, values in dict(frame).items():
            np.testing.assert_array_equal(values, file[name])
        table = frame.to_pandas()
        np.testing.assert_array_equal(table.index, file["id"])
        for i, part in enumerate("xx yy zz xy yz xz".split()):
            np.testing.assert_array_equal(table[f"stress-{part}"], file["stress"][:, i])
        np.testing.assert_array_equal(table["position-y"], file["position"][:, 1])
        np.testing.assert_array_equal(table["volume"], file["volume"])
    assert list(run.frame(-1).to_pandas("radius", "velocity").columns) == [
        "radius", "velocity-x", "velocity-y", "velocity-z",
    ]  # fmt: skip
    with pytest.raises(KeyError, match=r"no field 'strain' .*there are: body, displacement, id"):
        run.frame(0).to_pandas("strain")
    with pytest.raises(IndexError, match="no frame 3: it has 3"):
        run.frame(3)


def test_a_particle_is_followed(run):
    track = run.follow(7)
    for i, time_ in enumerate(run.times):
        file = content(run, i)
        row = list(file["id"]).index(7)
        assert track["time"][i] == time_
        np.testing.assert_array_equal(track["stress"][i], file["stress"][row])
    assert list(track.to_pandas()["stress-yy"]) == list(track["stress"][:, 1])
    with pytest.raises(KeyError, match="no particle 9999"):
        run.follow(9999)


def test_how_things_look_in_a_notebook(run, folder):
    assert repr(run) == f"<Run {folder / 'run'}: done, 20 steps, 3 frames>"
    assert repr(run.frame(1)).startswith("<Frame 1: t = 0.1, 36 particles; body, displacement, id")
    assert {"load", "run", "open", "Simulation", "register_material"} <= set(dir(pgimp))


def test_without_pandas(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for ask in (run.history.to_pandas, run.frame(0).to_pandas, run.follow(0).to_pandas):
        with pytest.raises(UsageError, match="pip install pandas"):
            ask()


def test_a_directory_that_is_run_anew_is_read_anew(tmp_path):
    case = BLOCK | {"output": {"every": 0.2}}
    run = pgimp.run(case, output=tmp_path / "run", quiet=True)
    before = run.frame(-1)["position"]
    changes = {"bodies.body.velocity": [0.0, 0.0], "output.fields": ["pressure"]}
    pgimp.run(case, output=tmp_path / "run", quiet=True, overwrite=True, overrides=changes)
    assert "pressure" in run.frame(-1)
    assert not np.array_equal(run.frame(-1)["position"], before)


def test_values_of_a_case_are_changed_by_key_paths(folder):
    """As on the command line; in files, in dictionaries, in cases, with NumPy's values."""
    path = folder / "block.yaml"
    words = [
        "grid.cell=[0.5,0.5]",
        "materials.soft.young=200",
        "bodies.body.region.box.min=[2,1.5]",
    ]
    values = {
        "grid.cell": np.full(2, 0.5),
        "materials.soft.young": np.float64(200.0),
        "bodies.body.region.box.min": (2, np.float32(1.5)),
    }
    wanted = pgimp.load(path, words)
    assert wanted.materials["soft"].young == 200.0
    original = pgimp.load(path)
    for source in (path, str(path), BLOCK, original):
        assert pgimp.load(source, values) == wanted
    assert original == pgimp.load(BLOCK) and pgimp.load(original) is original
    # A default that was never written does not stand in the way of another method.
    assert pgimp.load(original, {"method.shape": "mpm"}).method.shape == "mpm"


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"materials.soft.yung": 1.0}, "override of materials.soft.yung: .*did you mean 'young'"),
        ({"time.end": "1.0"}, r"override of time.end: time.end: expected a number, .*'1.0'"),
        ({"time.end": np.nan}, "override of time.end: time.end: "),
        ({"time.end.x": 1.0}, "override of time.end.x: time.end is 0.2 and has no key 'x'"),
        ({"output.at.0": 1.0}, "output.at.0"),
        ({"grid.": 1.0}, "expected a path of keys"),
        ({"materials.soft": {1: 2}}, "expected text as the key, got 1"),
        ({"time.end": object()}, "a value of type object"),
        ("time.end=1.0", "expected a list or a mapping of overrides, got the text"),
        (["time.end"], "expected KEY.PATH=VALUE"),
    ],
)
def test_wrong_overrides(overrides, message):
    with pytest.raises(CaseError, match=message):
        pgimp.load(BLOCK, overrides)


def test_wrong_sources(tmp_path):
    endless = dict(BLOCK)
    endless["bodies"] = endless
    for source, message in [
        (7, "expected a case, the name of its file or a dictionary .* got a value of type int"),
        ({}, "case: format: "),
        (BLOCK | {"dimension": 2}, "case: dimension: unknown key"),
        (endless, "nested deeper than 32 levels"),
    ]:
        with pytest.raises(CaseError, match=message):
            pgimp.load(source)
    with pytest.raises(UsageError, match="cannot read the case"):
        pgimp.load(tmp_path / "none.yaml")
    with pytest.raises(UsageError, match="needs output="):
        pgimp.run(BLOCK)


def test_a_simulation_driven_step_by_step_is_that_of_a_run(run):
    """Same bits, in ascending id, by the names of the fields."""
    sim = pgimp.Simulation(BLOCK)
    assert (sim.time, sim.steps, sim.finished) == (0.0, 0, False)
    for frame in run:
        sim.advance(frame.time)
        assert (sim.time, sim.steps) == (frame.time, frame.step)
        assert set(frame) <= set(sim.particles)
        for name in frame:
            np.testing.assert_array_equal(sim.particles[name], frame[name])
    assert sim.finished
    line = sim.diagnostics()
    assert line["strain-energy"] == run.history["strain-energy"][-1]
    assert line["dissipated-energy"] == run.history["dissipated-energy"][-1]
    table = sim.particles.to_pandas("stress")
    np.testing.assert_array_equal(table["stress-xy"], run.frame(-1)["stress"][:, 3])
    with pytest.raises(RunError, match=r"the case ends at t = 0\.2, after 20 steps"):
        sim.step()
    sim = pgimp.Simulation(BLOCK, overrides={"time.end": 0.1, "output.fields": []})
    sim.step()
    sim.step(3)
    assert sim.steps == 4 and sim.dt == 0.01 and not sim.finished
    sim.advance()
    assert sim.steps == 10
    with pytest.raises(KeyError, match="there is no field displacement; there are id"):
        sim.particles["displacement"]


def test_ctrl_c_leaves_a_run_that_goes_on(run, folder, capsys):
    """As a notebook's stop button: a KeyboardInterrupt, and a checkpoint."""
    output = folder / "interrupted"
    changes = {"time.step": 1e-4}
    whole = pgimp.run(BLOCK, output=folder / "whole", overrides=changes, quiet=True)
    main = threading.main_thread()

    def strike():
        while not (output / "history.csv").exists():
            time.sleep(0.001)
        signal.pthread_kill(main.ident, signal.SIGINT)

    striker = threading.Thread(target=strike, daemon=True)
    striker.start()
    with pytest.raises(KeyboardInterrupt):
        pgimp.run(BLOCK, output=output, overrides=changes)
    striker.join()
    assert pgimp.open(output).state == "stopped"
    assert "stopped on SIGINT at step" in capsys.readouterr().out
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    resumed = pgimp.run(BLOCK, output=output, overrides=changes, resume=True, quiet=True)
    assert resumed.state == "done" and resumed.info["resumed_from"] < 2000
    for mine, others in zip(whole, resumed, strict=True):
        for name in mine:
            np.testing.assert_array_equal(mine[name], others[name])
    assert whole.history.tobytes() == resumed.history.tobytes()


def test_results_are_read_without_mpi_numba_or_pandas(folder):
    words = "import sys, pgimp; print(*sys.modules); r = pgimp.open(sys.argv[1]); r.frame(0)['id']"
    words += "; r.history; r.follow(0); print(*sys.modules)"
    done = start(
        [sys.executable, "-c", words, str(folder / "run")], env={"MPI4PY_LIBMPI": os.devnull}
    )
    first, second = (set(line.split()) for line in done.stdout.splitlines())
    assert not first & {"numpy", "numba", "h5py", "mpi4py", "matplotlib", "pandas", "pydantic"}
    assert "h5py" in second and not second & {"numba", "pandas", "matplotlib"}


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: pgimp.run(BLOCK, output=""), "output: expected the name of a directory"),
        (lambda: pgimp.run(BLOCK, output="x", wall_time=-1), "wall_time: .* got -1"),
        (lambda: pgimp.run(BLOCK, output="x", wall_time=float("nan")), "wall_time: .* got nan"),
        (lambda: pgimp.Simulation(BLOCK).advance(float("nan")), "advance: .* got nan"),
        (lambda: pgimp.Simulation(BLOCK).step(-3), "step: .* got -3"),
        (lambda: pgimp.Simulation(BLOCK).step(1.5), "step: .* got 1.5"),
    ],
)
def test_arguments_that_mean_nothing(call, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=words):
        call()
    assert not [*tmp_path.iterdir()]
