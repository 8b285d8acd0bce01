"""Going on with a run of which something is damaged, lost or in the way."""

import json

import h5py
import pytest
from resumed import EVERY, check_same, steps

import pgimp
from pgimp.errors import RunError, UsageError
from pgimp.running.checkpoints import present


def test_half_a_line_and_half_a_file_of_a_run_that_was_killed_are_cut_off(run, whole):
    history = run.output / "history.csv"
    history.write_text(history.read_text()[:-30])
    (run.output / "frames" / ".particles-000009.h5.part").write_text("half")
    (run.output / "checkpoints" / ".step-000000999.h5.part").write_text("half")
    resumed = run()
    check_same(whole, resumed)
    assert not list(run.output.rglob("*.part"))


def test_what_is_missing_of_the_earlier_output_is_said(run, capsys):
    frames = sorted((run.output / "frames").iterdir())
    frames[1].unlink()
    frames[2].write_bytes(frames[2].read_bytes()[:100])
    history = run.output / "history.csv"
    history.write_text("".join(history.read_text().splitlines(keepends=True)[:3]))
    resumed = run(quiet=False)
    said = capsys.readouterr().out
    assert "note: 1 of the 8 earlier frames are missing" in said
    assert f"cannot read {frames[2]}" in said
    assert "history.csv ends at step 30, but it had a line of step 150: lines are missing" in said
    assert [*resumed.history["step"]] == [0, 30, 180, 200]
    assert (resumed.path / "particles.xdmf").read_text().count("<Time") == 8


@pytest.mark.parametrize(
    ("places", "words"),
    [
        # Lines of the steps 0, 30, 60, 90, 120, 150, 180 and 200; the checkpoint is of step 160.
        ([0, 1, 3, 4, 5, 6, 7], ":4: there are 5 lines up to step 150, but there were 6"),
        ([1, 2, 3, 4, 5, 6, 7], ":2: there are 5 lines up to step 150"),
        ([0, 4, 5, 6, 7], "gap is from step 0 to step 120"),
        ([0, 1, 2, 4, 3, 5, 6, 7], ":6: step 90 follows step 120"),
        ([0, 1, 2, 2, 3, 4, 5], ":5: step 60 follows step 60"),
        ([0, 1, 2, 3, 4, 6, 7], ":7: step 180 follows step 120, but there was a line of step 150"),
    ],
)
def test_lines_missing_inside_a_history_are_noticed(run, places, words):
    history = run.output / "history.csv"
    names, *lines = history.read_text().splitlines(keepends=True)
    history.write_text(names + "".join(lines[place] for place in places))
    before = history.read_bytes(), (run.output / "run.json").read_bytes()
    with pytest.raises(UsageError) as caught:
        run()
    assert words in str(caught.value) and "move it away" in str(caught.value)
    assert before == (history.read_bytes(), (run.output / "run.json").read_bytes())


def test_a_damaged_checkpoint_is_named_and_skipped(run, whole, capsys):
    newest = run.output / "checkpoints" / "step-000000160.h5"
    data = bytearray(newest.read_bytes())
    data[len(data) // 2] ^= 4
    newest.write_bytes(data)
    resumed = run(quiet=False)
    said = capsys.readouterr().out
    assert f"warning: {newest} cannot be used: " in said and "earlier" in said
    assert resumed.info["resumed_from"] == 120
    check_same(whole, resumed)
    assert steps(resumed) == [200, 160, 120]  # the damaged one has not pushed out an intact one
    assert newest.with_name(newest.name + ".damaged").read_bytes() == data


def test_a_checkpoint_open_in_another_program_is_not_called_damaged(run, whole, capsys):
    """HDF5 marks it while it is open for writing there, as a viewer may have it."""
    newest = present(run.output / "checkpoints")[0]
    before = newest.read_bytes()
    with h5py.File(newest, "r+", locking=False):
        assert newest.read_bytes() != before
        resumed = run(quiet=False)
    assert "cannot be used" not in capsys.readouterr().out
    assert resumed.info["resumed_from"] == 160
    check_same(whole, resumed)


def test_without_an_intact_checkpoint_nothing_is_touched(run):
    for path in present(run.output / "checkpoints"):
        path.write_bytes(path.read_bytes()[:-1])
    before = {path: path.read_bytes() for path in run.output.rglob("*") if path.is_file()}
    with pytest.raises(RunError, match=r"none of the 3 checkpoints in .* can be used"):
        run(back=200)
    after = {path: path.read_bytes() for path in run.output.rglob("*") if path.is_file()}
    assert after == before


def forget(run):
    """Let run.json say that there never was a checkpoint."""
    path = run.output / "run.json"
    info = json.loads(path.read_text())
    info["starts"][-1]["checkpoint"] = None
    path.write_text(json.dumps(info))


def test_checkpoints_that_have_gone_are_not_replaced_by_a_new_run(run):
    before = {path: path.read_bytes() for path in run.output.glob("frames/*")}
    with pytest.raises(RunError, match=r"last one of step 200\), but they have gone"):
        run(back=-1)
    (run.output / "checkpoints").rmdir()
    with pytest.raises(RunError, match="but they have gone"):
        run()
    assert {path: path.read_bytes() for path in run.output.glob("frames/*")} == before


def test_without_a_checkpoint_the_run_begins_anew(run, whole, capsys, tmp_path, folder):
    forget(run)
    resumed = run(back=-1, quiet=False)
    assert "no checkpoint in" in capsys.readouterr().out
    assert resumed.info["resumed_from"] is None
    check_same(whole, resumed)
    fresh = pgimp.run(
        folder / "blocks.yaml", output=tmp_path / "new", overrides=[EVERY], resume=True, quiet=True
    )
    check_same(whole, fresh)


def test_a_start_that_was_killed_while_it_cleared_the_directory_begins_anew(run, whole, capsys):
    """The old run's checkpoints may still be there, but its frames have gone."""
    path = run.output / "run.json"
    info = json.loads(path.read_text())
    info["starts"] = [info["starts"][-1] | {"state": "starting"}]
    path.write_text(json.dumps(info))
    for frame in run.output.glob("frames/*"):
        frame.unlink()
    resumed = run(back=200, quiet=False)
    assert "ended while it started: starting afresh" in capsys.readouterr().out
    check_same(whole, resumed)


def test_a_lost_run_json_does_not_keep_checkpoints_from_being_used(run, whole):
    path = run.output / "run.json"
    for text in (path.read_text()[:100], '{"program": "pgimp", "starts": []}'):
        path.write_text(text)
        check_same(whole, run())
        assert json.loads(path.read_text())["starts"][-1]["resumed_from"] == 160


def test_garbage_behind_the_line_of_the_checkpoint_is_cut_off(run, whole):
    history = run.output / "history.csv"
    lines = history.read_bytes().splitlines(keepends=True)
    kept = [line for line in lines if line[:1] not in b"t" and int(line.split(b",")[1]) <= 160]
    for garbage in (b"\0" * 50 + b"\n", b"\xff\xfe\n", b"1,2,3\n", b"nothing"):
        history.write_bytes(b"".join([lines[0], *kept, garbage]))
        check_same(whole, run())


def test_a_history_that_is_moved_away_ends_the_run(folder, tmp_path, monkeypatch):
    from pgimp.solver.simulation import Simulation

    advance = Simulation.advance

    def disturbed(sim, complete=True):
        advance(sim, complete)
        if sim.step == 50:
            (tmp_path / "run" / "history.csv").rename(tmp_path / "history.csv")

    monkeypatch.setattr(Simulation, "advance", disturbed)
    with pytest.raises(RunError, match=r"cannot write .*history\.csv: No such file"):
        pgimp.run(folder / "blocks.yaml", output=tmp_path / "run", quiet=True)


def test_without_a_checkpoint_another_case_is_refused_too(run):
    forget(run)
    with pytest.raises(UsageError, match=r"materials\.soft\.young is 200\.0, was 100\.0"):
        run("materials.soft.young=200.0", back=-1)


def test_a_checkpoint_under_another_name_is_not_used(run, whole, capsys):
    folder = run.output / "checkpoints"
    content = (folder / "step-000000120.h5").read_bytes()
    (folder / "step-000000160.h5").write_bytes(content)
    resumed = run(quiet=False)
    said = capsys.readouterr().out
    assert "step-000000160.h5 cannot be used: it is of step 120, which is not that of its" in said
    assert resumed.info["resumed_from"] == 120
    check_same(whole, resumed)


@pytest.mark.parametrize(
    ("overwrite", "words"), [(False, "--resume goes on"), (True, "--resume in place of --overw")]
)
def test_a_stopped_run_says_how_to_go_on(folder, tmp_path, capsys, overwrite, words):
    """The command that replaces a run is refused with --resume."""
    overrides = ["time.end=200000.0", "output={every: null}"]
    pgimp.run(folder / "blocks.yaml", output=tmp_path / "run", overrides=overrides,
              overwrite=overwrite, wall_time=1.2)  # fmt: skip
    assert f"the same command with {words}" in " ".join(capsys.readouterr().out.split())
