"""A disk that fills up: an error on every rank, and nothing lost of what was there."""

import sys
import xml.etree.ElementTree
from pathlib import Path

import numpy as np
import pytest
from particle_source import Lines, fill_up, make_case, make_sim, small_disk, write_frames
from processes import HERE
from tiers import wide

from pgimp.errors import RunError
from pgimp.io.results.history import History
from pgimp.io.results.reader import Frame
from pgimp.mpi.comm import Serial, world
from pgimp.running.frames import Frames


@pytest.fixture
def disk(tmp_path):
    with small_disk(tmp_path / "disk") as place:
        yield place


def check_full_disk(directory, before):
    """On a disk that filled up, the frames that are there are whole and the series lists them."""
    names = sorted(path.name for path in (directory / "frames").iterdir())
    assert names == [f"particles-{number:06d}.h5" for number in range(before)]
    for name in names:
        frame = Frame(directory / "frames" / name)
        np.testing.assert_array_equal(frame["id"], np.arange(len(frame)))
        assert np.isfinite(frame["stress"]).all() and frame["stress"].all()
    document = xml.etree.ElementTree.parse(directory / "particles.xdmf")
    items = {item.text.split(":")[0] for item in document.iter("DataItem")}
    assert items == {f"frames/{name}" for name in names}


@pytest.mark.parametrize("ranks", [1, wide(2), 3])
def test_a_full_disk_stops_the_run_and_spoils_nothing(disk, mpirun, ranks):
    # A frame takes about 395 bytes a particle, so that the fourth does not fit.
    job = mpirun(ranks, [__file__, disk, 680], env=HERE)
    assert job.returncode == 0, job.stdout + job.stderr
    messages = job.stdout.splitlines()
    assert len(messages) == ranks and len(set(messages)) == 1
    assert "particles-000003.h5" in messages[0] and "No space left on device" in messages[0]
    check_full_disk(disk, 3)


def test_any_amount_of_free_space_is_handled(disk):
    """From no free block to all but enough: always an error, never a file or a crash."""
    (disk / "frames").mkdir()
    sim, _ = make_sim(Serial(), 400, 3)
    frames = Frames(disk, make_case(), sim)
    frames.write(sim)
    frames.finish()
    size = (disk / "frames" / "particles-000000.h5").stat().st_size
    for free in range(0, size, 8192):
        ballast = fill_up(disk, but=free)
        with pytest.raises(RunError, match="No space left"):
            frames.write(sim)
        ballast.unlink()
        check_full_disk(disk, 1)
    frames.write(sim)
    frames.finish()
    check_full_disk(disk, 2)


def test_history_on_a_full_disk_keeps_whole_lines(disk):
    sim, history = Lines(), History(disk / "history.csv")
    history.write(sim)
    fill_up(disk)
    with pytest.raises(RunError, match=r"history\.csv: No space left"):
        for step in range(1, 100):
            sim.step = step
            history.write(sim)
    history.close()
    lines = (disk / "history.csv").read_text().splitlines(keepends=True)
    assert len(lines) > 10
    assert {(line.count(","), line[-1]) for line in lines} == {(8, "\n")}


if __name__ == "__main__":
    try:
        write_frames(Path(sys.argv[1]), world(), int(sys.argv[2]), 3, number=100)
    except RunError as error:
        print(f"{error}\n", end="", flush=True)
