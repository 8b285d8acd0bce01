"""``pgimp plot -o FILE.gif``: a picture of each frame, in one range of colours."""

import pytest
from two_blocks import CASE

import pgimp
from pgimp import cli


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("movie")
    (folder / "blocks.yaml").write_text(CASE)
    short = ["output.every=1.0", "output.at=[]"]
    return pgimp.run(folder / "blocks.yaml", output=folder / "a", overrides=short, quiet=True)


def test_a_movie_has_all_frames_in_one_size(run, tmp_path, capsys):
    from PIL import Image

    path = tmp_path / "run.gif"
    assert cli.main(["plot", str(run.path), "-o", str(path), "--rate", "4", "--width", "3"]) == 0
    with Image.open(path) as found:
        assert found.n_frames == len(run.frames) == 3
        assert found.info["duration"] == 250 and min(found.size) > 100
        assert not any(side % 2 for side in found.size)
    assert capsys.readouterr().out == f"wrote {path}\n"


def test_what_it_is_made_with_must_be_there(run, tmp_path, monkeypatch, capsys):
    from matplotlib.animation import writers

    monkeypatch.setattr(writers, "is_available", lambda name: False)
    assert cli.main(["plot", str(run.path), "-o", str(tmp_path / "run.mp4")]) == 2
    assert "needs ffmpeg" in capsys.readouterr().err
