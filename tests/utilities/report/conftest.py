"""A run of two blocks, copies of it, and the command."""

import shutil

import pytest
from two_blocks import CASE

import pgimp
from pgimp import cli


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "blocks.yaml").write_text(CASE)
    return pgimp.run(folder / "blocks.yaml", output=folder / "blocks.out", quiet=True)


@pytest.fixture
def copied(whole, tmp_path):
    """A copy of the run that may be changed."""
    return shutil.copytree(whole.path, tmp_path / "blocks.out")


@pytest.fixture
def report(capsys):
    """``report(DIR, ...)``: status, output and errors."""

    def call(*words):
        status = cli.main(["report", *map(str, words)])
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        return status, said.out, said.err

    return call
