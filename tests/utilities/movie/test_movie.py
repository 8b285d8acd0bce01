"""``pgimp plot -o FILE.gif`` or .mp4: a picture of each frame, in one range of colours."""

import ast
import os
import sys

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


def test_a_movie_of_contours_under_a_style_that_cuts_pictures(run, tmp_path):
    from PIL import Image

    path, style = tmp_path / "run.gif", tmp_path / "paper.mplstyle"
    style.write_text("savefig.bbox: tight\n")
    words = ["--contours", "--field", "velocity.y", "--style", str(style), "-o", str(path)]
    assert cli.main(["plot", str(run.path), *words]) == 0
    with Image.open(path) as found:
        assert found.n_frames == 3


#: A program that keeps its words and pictures, and writes what begins as a film does.
_RECORDER = """#!{python}
import sys
pictures = sys.stdin.buffer.read()
open({log!r}, "w").write(repr((sys.argv[1:], len(pictures))))
open(sys.argv[-1], "wb").write(b"0000ftypisom")
"""
_BROKEN = """#!{python}
import sys
sys.exit("Unknown encoder 'h264'")
"""


def ffmpeg(folder, monkeypatch, text):
    """Put a program of this name first on the PATH."""
    path = folder / "bin" / "ffmpeg"
    path.parent.mkdir()
    path.write_text(text.format(python=sys.executable, log=str(folder / "log")))
    path.chmod(0o755)
    monkeypatch.setenv("PATH", f"{path.parent}{os.pathsep}{os.environ['PATH']}")


def test_ffmpeg_gets_every_picture(run, tmp_path, monkeypatch):
    """In pixels of one size, at the wanted rate, for players that know one format only."""
    ffmpeg(tmp_path, monkeypatch, _RECORDER)
    path = tmp_path / "run.mp4"
    for _ in range(2):  # it may be replaced
        assert cli.main(["plot", str(run.path), "-o", str(path), "--rate", "4"]) == 0
    assert path.read_bytes() == b"0000ftypisom"
    words, count = ast.literal_eval((tmp_path / "log").read_text())
    wide, high = map(int, words[words.index("-s") + 1].split("x"))
    assert wide % 2 == high % 2 == 0 and count == 3 * 4 * wide * high
    assert float(words[words.index("-framerate") + 1]) == 4.0
    assert words[words.index("-vcodec", words.index("-i")) + 1] == "h264"
    assert "yuv420p" in words


def test_what_ffmpeg_says_when_it_fails(run, tmp_path, monkeypatch, capsys):
    ffmpeg(tmp_path, monkeypatch, _BROKEN)
    assert cli.main(["plot", str(run.path), "-o", str(tmp_path / "run.mp4")]) == 2
    said = capsys.readouterr().err
    assert "ffmpeg has failed: Unknown encoder 'h264'; try a .gif" in said
    assert not (tmp_path / "run.mp4").exists()


def test_what_it_is_made_with_must_be_there(run, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert cli.main(["plot", str(run.path), "-o", str(tmp_path / "run.mp4")]) == 2
    assert "needs the program ffmpeg, which is not here; a .gif" in capsys.readouterr().err
