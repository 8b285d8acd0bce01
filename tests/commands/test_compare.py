"""``pgimp compare`` on pairs of runs that differ in one known thing of particles or history."""

import shutil

import h5py
import numpy as np
import pytest
from compared import call
from mentioned import mentions
from run_pair import COUNT, run_pair

from pgimp.commands import compare
from pgimp.errors import RunError, UsageError


@pytest.fixture
def pair(tmp_path):
    return run_pair(tmp_path)


def change(directory, number, field, index, value):
    """Put a value at an index of a field; returns the value before."""
    with h5py.File(directory / "frames" / f"particles-{number:06d}.h5", "r+") as file:
        before = file[field][index]
        file[field][index] = value(before)
        return float(before)


def test_same_runs(pair, capsys):
    status, out = call(capsys, *pair)
    assert status == 0
    assert "the same bit for bit: 3 frames of 31 particles, 3 lines of history" in out


def test_one_bit(pair, capsys):
    before = change(pair[1], 1, "stress", (17, 3), lambda value: np.nextafter(value, 9.0))
    after = float(np.nextafter(before, 9.0))
    status, out = call(capsys, *pair)
    assert status == 1
    told, end = out.splitlines()
    mentions(told, "frame 1 (t = 0.1)", "stress", "1 of 31 particles", "particle 17 xy")
    mentions(told, f"{before!r} and {after!r}", f"{after - before:.3g}")
    mentions(end, *pair, "differ")
    assert call(capsys, *pair, "--rtol", "1e-15")[0] == 0
    assert call(capsys, *pair, "--atol", "1e-15")[0] == 0


def test_the_worst_particle_is_named(pair, capsys):
    for row, shift in ((3, 0.5), (30, 2.0), (5, 1.0)):
        change(pair[1], 2, "velocity", (row, 1), lambda value, shift=shift: value + shift)
    out = call(capsys, *pair)[1]
    assert "velocity: 3 of 31 particles differ, worst is particle 30 y: " in out
    assert "difference 2\n" in out
    status, out = call(capsys, *pair, "--atol", "0.75")
    assert status == 1 and "velocity: 2 of 31 particles differ" in out
    assert call(capsys, *pair, "--atol", "2.1")[0] == 0


def test_tolerance_is_relative_to_the_larger(pair, capsys):
    change(pair[0], 0, "volume", 4, lambda value: 8.0)
    change(pair[1], 0, "volume", 4, lambda value: 10.0)
    assert call(capsys, *pair, "--rtol", "0.19")[0] == 1
    for directories in (pair, pair[::-1]):
        assert call(capsys, *directories, "--rtol", "0.21")[0] == 0


@pytest.mark.parametrize("options", [(), ("--rtol", "1e-9")])
def test_zeros_and_what_is_no_number(pair, capsys, options):
    for directory in pair:
        change(directory, 0, "pressure", 2, lambda value: np.nan)
        change(directory, 0, "pressure", 3, lambda value: np.inf)
    assert call(capsys, *pair, *options)[0] == 0
    change(pair[0], 1, "pressure", 5, lambda value: 0.0)
    change(pair[1], 1, "pressure", 5, lambda value: -0.0)
    status, out = call(capsys, *pair, *options)
    assert status == (0 if options else 1)
    assert options or "particle 5: 0.0 and -0.0, difference 0\n" in out
    change(pair[1], 2, "pressure", 7, lambda value: np.nan)
    change(pair[1], 2, "pressure", 8, lambda value: value + 100.0)
    status, out = call(capsys, *pair, *options)
    assert status == 1 and "worst is particle 7: " in out and "and nan, difference inf\n" in out
    change(pair[1], 0, "pressure", 3, lambda value: -np.inf)
    assert "particle 3: inf and -inf" in call(capsys, *pair, *options)[1]


def test_blocks_count_together(pair, capsys, monkeypatch):
    for row, shift in ((3, 2.0), (17, 3.0), (29, 1.0)):
        change(pair[1], 0, "volume", row, lambda value, shift=shift: value + shift)
    monkeypatch.setattr(compare, "_BLOCK_ROWS", 8)
    out = call(capsys, *pair)[1]
    assert "volume: 3 of 31 particles differ, worst is particle 17: " in out


def test_other_order(pair, capsys):
    path = pair[1] / "frames" / "particles-000001.h5"
    with h5py.File(path, "r+") as file:
        del file["VTKHDF"]
        for dataset in file.values():
            dataset[...] = dataset[:][::-1]
    status, out = call(capsys, *pair)
    assert status == 1 and "frame 1 (t = 0.1): the particles have other ids or another order" in out


def test_particles_that_left_one_run(pair, capsys, monkeypatch):
    """Those that both have are compared by their ids, also where blocks of rows do not match."""
    monkeypatch.setattr(compare, "_BLOCK_ROWS", 4)
    change(pair[0], 1, "stress", (30, 3), lambda value: 9.0)
    change(pair[1], 1, "stress", (30, 3), lambda value: 7.0)
    change(pair[1], 1, "volume", 8, lambda value: value + 1.0)  # of a particle only there
    for directory, gone in zip(pair, ([2, 3, 8, 9, 10, 20], [*range(20, 29)]), strict=True):
        with h5py.File(directory / "frames" / "particles-000001.h5", "r+") as file:
            del file["VTKHDF"]
            for name in list(file):
                attributes, values = dict(file[name].attrs), np.delete(file[name][:], gone, axis=0)
                del file[name]
                file[name] = values
                file[name].attrs.update(attributes)
    status, out = call(capsys, *pair)
    assert status == 1
    first, second, stress, _ = out.splitlines()
    assert all(line.startswith("frame 1 (t = 0.1)") for line in (first, second, stress))
    mentions(first, "8 of 25 particles", f"only in {pair[0]}", "21, 22, 23, 24, 25, ...")
    mentions(second, "5 of 22 particles", f"only in {pair[1]}", "2, 3, 8, 9, 10")
    assert second.endswith("10")
    mentions(stress, "stress", "1 of 17 particles", "particle 30 xy", "9.0 and 7.0", "difference 2")


@pytest.mark.parametrize("swap", [False, True])
def test_another_precision_is_told_once(pair, capsys, swap):
    for path in (pair[1] / "frames").iterdir():
        with h5py.File(path, "r+") as file:
            del file["VTKHDF"]
            for name in [name for name in file if file[name].dtype == np.float64]:
                values = file[name][()].astype(np.float32)
                del file[name]
                file[name] = values
    change(pair[1], 1, "body", 3, lambda value: 1 - value)
    one, two = pair[::-1] if swap else pair
    kinds = ("float32", "float64") if swap else ("float64", "float32")
    status, out = call(capsys, one, two)
    assert status == 1
    first, second, _ = out.splitlines()
    mentions(first, "frame 0", f"{kinds[0]} in {one}", f"{kinds[1]} in {two}")
    mentions(second, "frame 1 (t = 0.1)", "body", "1 of 31 particles")
    change(pair[1], 1, "body", 3, lambda value: 1 - value)
    assert call(capsys, one, two, "--rtol", "1e-6")[0] == 0
    assert call(capsys, one, two, "--rtol", "1e-8")[0] == 1
    assert call(capsys, pair[1], pair[1])[0] == 0


def test_missing_frame(pair, capsys):
    (pair[1] / "frames" / "particles-000002.h5").unlink()
    for directories in (pair, pair[::-1]):
        status, out = call(capsys, *directories)
        assert status == 1
        mentions(out, "1 of 3 frames", f"only in {pair[0]}: 2\n")


def test_other_time_step_fields_and_number(pair, capsys):
    frames = pair[1] / "frames"
    with h5py.File(frames / "particles-000000.h5", "r+") as file:
        file.attrs["step"] = 5
    with h5py.File(frames / "particles-000001.h5", "r+") as file:
        file.attrs["time"] = np.nextafter(0.1, 1.0)
        del file["stress"]
        volume = file["volume"][:].astype("f4")
        del file["volume"]
        file["volume"] = volume
    with h5py.File(frames / "particles-000002.h5", "r+") as file:
        ids = file["id"][:-1]
        del file["id"]
        file["id"] = ids
    status, out = call(capsys, *pair)
    assert status == 1
    step, instant, field, kind, number, _ = out.splitlines()
    mentions(step, "frame 0 (t = 0)", "step 0 and 5")
    mentions(instant, "frame 1 (t = 0.1)", "time 0.1 and 0.10000000000000002")
    mentions(field, "frame 1 (t = 0.1)", f"only {pair[0]}", "stress")
    mentions(kind, "frame 1 (t = 0.1)", "volume", "type")
    mentions(number, "frame 2 (t = 0.2)", "1 of 31 particles", f"only in {pair[0]}", "30")


def test_history(pair, capsys):
    path = pair[1] / "history.csv"
    lines = path.read_text().splitlines()
    cells = lines[2].split(",")
    cells[4] = "1.5e200"
    path.write_text("\n".join([*lines[:2], ",".join(cells), lines[3]]) + "\n")
    status, out = call(capsys, *pair)
    assert status == 1
    mentions(out.splitlines()[0], "history.csv", "value_1", "1 of 3 lines", "line 3")
    path.write_text("\n".join(lines[:3]) + "\n")
    assert "history.csv: 3 and 2 lines" in call(capsys, *pair)[1]
    path.write_text("\n".join([lines[0].replace("dt", "step-size"), *lines[1:]]) + "\n")
    assert "history.csv: other columns (dt, step-size)" in call(capsys, *pair)[1]
    path.unlink()
    assert call(capsys, *pair)[0] == 1


def test_many_differences_are_cut_short(pair, capsys, monkeypatch):
    monkeypatch.setattr(compare, "_MOST_LINES", 2)
    for number in range(3):
        change(pair[1], number, "volume", 0, lambda value: value + 1.0)
        change(pair[1], number, "radius", 0, lambda value: value + 1.0)
    lines = call(capsys, *pair)[1].splitlines()
    assert len(lines) == 4
    mentions(lines[2], "4 further")


def test_what_is_no_run(pair, tmp_path, capsys):
    for second in (tmp_path / "nowhere", tmp_path, pair[0] / "run.json"):
        with pytest.raises(UsageError, match="is no run directory"):
            call(capsys, pair[0], second)
    shutil.rmtree(pair[1] / "frames")
    with pytest.raises(UsageError, match="holds no frame yet"):
        call(capsys, *pair)
    for option in (("--rtol", "-1"), ("--atol", "nan")):
        with pytest.raises(UsageError, match=f"{option[0]} must be a number"):
            call(capsys, pair[0], pair[0], *option)


def test_a_damaged_frame_is_named(pair, capsys):
    path = pair[1] / "frames" / "particles-000001.h5"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(RunError, match=r"cannot read .*particles-000001\.h5"):
        call(capsys, *pair)


def test_the_rank_may_differ(pair, capsys):
    """By its nature it does; that it is there in one run alone is told as of any field."""
    for number, directory in enumerate(pair):
        for path in (directory / "frames").iterdir():
            with h5py.File(path, "r+") as file:
                file["rank"] = np.full(COUNT, number, np.int32)
    assert call(capsys, *pair)[0] == 0
    with h5py.File(pair[0] / "frames" / "particles-000001.h5", "r+") as file:
        del file["rank"]
    status, out = call(capsys, *pair)
    assert status == 1 and f"only {pair[1]} has the field rank" in out
