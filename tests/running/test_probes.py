"""Probes: against exact solutions and the frames. On any ranks: test_balance.py, test_ranks.py."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from rank_scenes import PROBES, plane_leaves
from run_files import go_back
from scenes import box, finish, scene, start, write_case

import pgimp
from pgimp.errors import RunError, UsageError
from pgimp.files.lines import LineFile
from pgimp.mpi.comm import Serial
from pgimp.solver.probes import nearest

CASES = Path(__file__).parents[2] / "cases"
FIELDS = ["velocity", "stress", "displacement", "strain", "pressure", "von-mises", "density"]


def run(folder, case, **options):
    """Run a case in this process and return its results."""
    write_case(folder / "case.yaml", case)
    return pgimp.run(folder / "case.yaml", output=folder / "out", quiet=True, **options)


def test_the_tip_of_the_bar(tmp_path):
    """The probe swings as the exact solution says; see the comments in the case."""
    probe = "probes={tip: {body: bar, at: [1.0], every: {steps: 5}}}"
    result = pgimp.run(
        CASES / "bar-vibration.yaml", output=tmp_path, quiet=True, overrides=[probe, "time.end=0.6"]
    )
    tip = result.probes["tip"]
    assert tip["step"].tolist() == list(range(0, 3001, 5))
    assert tip["position-x"][0] == 0.995  # the lowest particle
    phase, g, T = np.mod(tip["time"], 0.2), 9.81, 0.2
    sag = g / 400.0
    exact = np.where(phase < T / 4, g * phase**2 / 2, sag - g * (phase - T / 2) ** 2 / 2)
    exact = np.where(phase > 3 * T / 4, g * (T - phase) ** 2 / 2, exact)
    assert np.abs(tip["displacement-x"] - exact).max() < 0.21e-3
    assert np.ptp(exact) > 0.024
    np.testing.assert_allclose(tip["displacement-x"], tip["position-x"] - 0.995, rtol=0, atol=1e-15)
    # And it is the particle of that id in the frames.
    frames = result.follow(99)
    rows = np.searchsorted(tip["step"], frames["step"])
    for name in ("displacement", "velocity"):
        assert np.array_equal(tip[f"{name}-x"][rows], frames[name][:, 0])
    assert np.array_equal(tip["stress-xx"][rows], frames["stress"][:, 0])


@pytest.fixture(scope="module")
def leaves(tmp_path_factory):
    """A run on one rank, in which two of the bodies leave the domain, with frames at all lines."""
    folder = tmp_path_factory.mktemp("probes")
    case = plane_leaves() | {"probes": PROBES}
    case["output"] = {"every": {"steps": 1}, "fields": FIELDS}
    return run(folder, case)


def columns(frame, row):
    """What a frame holds of a particle, by the names that a probe has for it in 2D."""
    names = {}
    for field, parts in (("position", "x y"), ("displacement", "x y"), ("velocity", "x y"),
                         ("stress", "xx yy zz xy"), ("strain", "xx yy . xy")):  # fmt: skip
        for i, part in enumerate(parts.split()):
            names[f"{field}-{part}"] = frame[field][row, i]
    names.pop("strain-.")
    return names | {
        name: frame[name][row] for name in ("pressure", "von-mises", "density", "volume")
    }


@pytest.mark.parametrize("name", ["corner", "down"])
def test_a_point_is_a_particle_of_the_frames_until_it_leaves(leaves, name):
    first, probe = leaves.frame(0), leaves.probes[name]
    mine = np.flatnonzero(first["body"] == first.bodies.index(PROBES[name]["body"]))
    away = ((first["position"][mine, :2] - PROBES[name]["at"]) ** 2).sum(axis=1)
    number = mine[np.flatnonzero(away == away.min())[0]]
    frames = {frame.step: frame for frame in leaves}
    assert (away == away.min()).sum() == {"corner": 4, "down": 1}[name]
    seen = 0
    for line in probe:
        frame = frames[int(line["step"])]
        rows = np.flatnonzero(frame["id"] == number)
        if len(rows):
            seen += 1
            wanted = columns(frame, rows[0])
            assert set(wanted) | {"time", "step"} == set(probe.dtype.names)
            assert all(line[key] == value for key, value in wanted.items())
        else:
            assert np.isnan([line[key] for key in probe.dtype.names[2:]]).all()
    assert 3 < seen < len(probe)  # and then it left
    if name == "down":
        times = 0.08 * np.arange(16)
        step = leaves.history["dt"].max()
        assert ((probe["time"] >= times - 1e-9) & (probe["time"] <= times + step)).all()
    else:
        assert np.array_equal(probe["step"], leaves.history["step"])


@pytest.mark.parametrize("name", ["gate", "floor"])
def test_a_place_is_the_mean_of_what_is_there(leaves, name):
    """The sums once more, in plain NumPy over all particles of the frame."""
    probe, frames = leaves.probes[name], {frame.step: frame for frame in leaves}
    filled = 0
    for line in probe:
        frame = frames[int(line["step"])]
        away = np.abs(frame["position"][:, :2] - PROBES[name]["place"])
        volume = np.maximum(0.0, 1.0 - away).prod(axis=1) * frame["volume"]
        mass = volume * frame["density"]
        assert line["volume-fraction"] == pytest.approx(volume.sum(), rel=1e-12, abs=1e-15)
        values = [line[key] for key in probe.dtype.names[3:]]
        if volume.sum() < 0.25:
            assert np.isnan(values).all()
            continue
        filled += 1
        velocity = mass @ frame["velocity"] / mass.sum()
        stress = volume @ frame["stress"] / volume.sum()
        xx, yy, zz, xy = stress[:4]
        mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)
        wanted = [mass.sum() / volume.sum(), *velocity[:2], *stress[:4], -(xx + yy + zz) / 3, mises]
        np.testing.assert_allclose(values, wanted, rtol=1e-9, atol=1e-9)
    assert 5 < filled < len(probe)


def test_a_resumed_run_may_have_other_probes_as_far_as_they_are_known(tmp_path):
    case = scene(1, box([1.0], [5.0], [1.0]), end=0.4, history={"every": {"steps": 10}})
    probes = {"a": {"body": "body", "at": [2.0]}, "b": {"place": [3.0]}}
    stop = {"checkpoint": {"every": {"steps": 10}, "keep": 9}}
    before = run(tmp_path, case | {"probes": probes} | stop)
    whole = {path.name: path.read_text() for path in (before.path / "probes").iterdir()}
    go_back(before.path, 0.5)

    def again(probes):
        copy = tmp_path / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(tmp_path / "out", copy / "out")
        return run(copy, case | {"probes": probes} | stop, resume=True)

    with pytest.raises(UsageError, match=r"probes\.c: the run began without it"):
        again(probes | {"c": {"body": "body", "at": [2.0]}})
    for other in ({"place": [2.0]}, {"body": "body", "at": [2.1]}):
        with pytest.raises(UsageError, match=r"probes\.a: .* another probe of this name"):
            again({"a": other})
    result = again(probes | {"c": {"place": [4.0]}})
    assert result.info["resumed_from"] == 20
    assert result.probes["c"]["step"].tolist() == [30, 40]
    for name, text in whole.items():
        assert (result.path / "probes" / name).read_text() == text


def test_overwriting_takes_the_files_of_the_probes_and_no_others(tmp_path):
    case = scene(1, box([1.0], [5.0]), end=0.1)
    result = run(tmp_path, case | {"probes": {"a": {"place": [3.0]}, "b": {"place": [4.0]}}})
    (result.path / "probes" / "mine.csv").write_text("time\n")
    run(tmp_path, case | {"probes": {"b": {"place": [2.0]}}}, overwrite=True)
    assert sorted(path.name for path in (result.path / "probes").iterdir()) == ["b.csv", "mine.csv"]
    assert list(result.probes) == ["b"]


def test_a_run_without_probes_has_no_folder(tmp_path):
    result = run(tmp_path, scene(1, box([1.0], [5.0]), end=0.1))
    assert not (result.path / "probes").exists() and result.probes == {}


def test_of_equally_close_particles_the_lowest_id():
    sim = start(scene(2, box([1.0, 1.0], [3.0, 3.0])))
    assert nearest(sim, 0, [1.5, 1.5]).number == 0
    p, rows = sim.particles, sim.live()
    ids = p.id[rows[np.abs(p.x[rows] - 2.0).max(axis=1) < 0.3]]
    assert len(ids) == 4 and nearest(sim, 0, [2.0, 2.0]).number == ids.min()


# Reactions


def test_the_floor_bears_the_weight_of_a_block():
    """At rest, up to what the relaxation has left of the oscillation."""
    case = scene(
        2,
        box([1.0, 0.0], [3.0, 2.0]),
        cells=[4, 4],
        end=20.0,
        step=0.02,
        gravity=[0.0, -0.5],
        boundaries={"y-min": "slip"},
    )
    case["method"]["relaxation"] = 4.0
    sim = start(case)
    sim.diagnostics()
    while sim.time < 19.0:
        sim.advance()
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert line["reaction.y-min-y"] == pytest.approx(0.5 * line["mass"], rel=2e-5)
    assert line["reaction.y-min-x"] == pytest.approx(0.0, abs=1e-9)
    assert line["kinetic-energy"] < 1e-9


def test_a_constraint_bears_the_weight_that_hangs_from_it():
    """A block held at its top: the constraint's force is the weight, and it does no work."""
    held = {"box": {"min": [1.0, 2.0], "max": [3.0, 3.0]}}
    case = scene(
        2,
        box([1.0, 1.0], [3.0, 3.0]),
        cells=[4, 4],
        end=20.0,
        step=0.02,
        gravity=[0.0, -0.5],
        constraints={"top": {"body": "body", "region": held, "velocity": [0.0, 0.0]}},
    )
    case["method"]["relaxation"] = 4.0
    sim = start(case)
    sim.diagnostics()
    while sim.time < 19.0:
        sim.advance()
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert line["constraint.top-y"] == pytest.approx(0.5 * line["mass"], rel=1e-6)
    assert line["constraint.top-x"] == pytest.approx(0.0, abs=1e-9)


def test_the_bodies_add_up_to_the_whole(leaves):
    """Mass and momentum of each body; once one has left there is none of it."""
    lines, names = leaves.history, leaves.frame(0).bodies
    for column in ("mass", "momentum-x", "momentum-y", "kinetic-energy", "strain-energy"):
        parts = np.sum([lines[f"body.{name}.{column}"] for name in names], axis=0)
        np.testing.assert_allclose(parts, lines[column], rtol=1e-12, atol=1e-12)
    assert lines["body.corner.mass"][0] == pytest.approx(4.0, rel=1e-14)
    assert lines["body.corner.momentum-x"][0] == pytest.approx(20.0, rel=1e-12)
    assert lines["body.corner.mass"][-1] == lines["body.corner.momentum-x"][-1] == 0.0


def test_lines_of_a_probe_that_comes_back_stay(tmp_path):
    """A resume that has a place again, of which it has no record, keeps what was seen before."""
    path = tmp_path / "gauge.csv"
    path.write_bytes(b"time,step,density\n0,0,1\n0.1,10,2\n0.2,20,3\n0.3,3")
    file = LineFile(path)
    file.resume(Serial(), 15)
    file.append({"time": 0.16, "step": 16, "density": 4.0})
    file.sync()
    file.close()
    lines = path.read_text().split()
    assert lines[:-1] == ["time,step,density", "0,0,1", "0.1,10,2"]
    assert [float(x) for x in lines[-1].split(",")] == [0.16, 16, 4]


@pytest.mark.parametrize("left", [b"", b"time,st", b"time,step\n0.1,10\n"])
def test_a_file_before_its_first_line_never_stops_a_resume(tmp_path, left):
    path = tmp_path / "late.csv"
    path.write_bytes(left)
    file = LineFile(path)
    file.resume(Serial(), -1)
    assert file.step == -1 and path.read_bytes() == b""


def test_overwriting_takes_the_files_of_probes_that_a_resume_has_dropped(tmp_path):
    case = scene(1, box([1.0], [5.0]), end=0.4, history={"every": {"steps": 10}})
    case |= {"checkpoint": {"every": {"steps": 10}, "keep": 9}}
    probes = {"a": {"place": [3.0]}, "b": {"place": [4.0]}, "c": {"place": [5.0]}}
    result = run(tmp_path, case | {"probes": probes})
    for _ in range(2):  # the second resume knows of c from what the first has kept
        go_back(result.path, 0.5)
        del probes[max(probes)]
        assert list(run(tmp_path, case | {"probes": probes}, resume=True).probes) == list(probes)
    assert result.info["probes"] == ["a", "b", "c"]
    (result.path / "probes" / "mine.csv").write_text("time\n")
    run(tmp_path, case, overwrite=True)
    assert [path.name for path in (result.path / "probes").iterdir()] == ["mine.csv"]
    assert result.info["probes"] == []


def test_a_start_that_was_killed_knows_the_probes_of_the_run_before(tmp_path, monkeypatch):
    """run.json says that a run starts before the old one's files go; it keeps their names."""

    def killed(path, **_):
        raise OSError("killed")

    case = scene(1, box([1.0], [5.0]), end=0.1)
    result = run(tmp_path, case | {"probes": {"a": {"place": [3.0]}}})
    (result.path / "case.yaml").unlink()  # nothing but run.json knows of the probe
    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", killed)
        with pytest.raises(RunError, match="killed"):
            run(tmp_path, case, overwrite=True)
    assert result.state == "starting" and (result.path / "probes" / "a.csv").exists()
    run(tmp_path, case, overwrite=True)
    assert not (result.path / "probes" / "a.csv").exists()


@pytest.mark.parametrize("way", ["overwrite", "resume"])
def test_what_is_in_the_way_of_a_probe_is_found_before_anything_is_deleted(tmp_path, way):
    case = scene(1, box([1.0], [5.0]), end=0.2)
    result = run(tmp_path, case)
    folder = result.path / "probes"
    folder.write_text("mine")
    before = contents(result.path)
    for probes in ({"a": {"place": [3.0]}}, {}):
        if probes:
            with pytest.raises(UsageError, match=r"probes is in the way (.|\n)*move it away"):
                run(tmp_path, case | {"probes": probes}, **{way: True})
            assert contents(result.path) == before
        else:  # nothing is to be written there
            run(tmp_path, case | {"probes": probes}, **{way: True})
            assert folder.read_text() == "mine"
    folder.unlink()
    folder.mkdir()
    (folder / "a.csv").write_text("mine")
    with pytest.raises(UsageError, match=r"a\.csv is in the way .* no earlier start has written"):
        run(tmp_path, case | {"probes": {"a": {"place": [3.0]}}}, **{way: True})
    assert (folder / "a.csv").read_text() == "mine"


def contents(directory):
    return {path: path.read_bytes() for path in directory.rglob("*") if path.is_file()}
