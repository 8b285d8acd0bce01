"""A run, and copies of it that were killed."""

import json
import shutil

import pytest
from resumed import EVERY
from two_blocks import CASE

import pgimp
from pgimp.running.checkpoints import number_of, present


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("resume")
    (folder / "blocks.yaml").write_text(CASE)
    return folder


@pytest.fixture(scope="module")
def whole(folder):
    """A run that was never stopped."""
    return pgimp.run(folder / "blocks.yaml", output=folder / "whole", overrides=[EVERY], quiet=True)


@pytest.fixture
def run(folder, tmp_path, whole):
    """``run(*overrides, back=80)`` resumes a copy of the run, from step 80 if nothing is changed.

    The copy is as if the run had been killed before its next checkpoint.
    """
    output = tmp_path / "run"
    shutil.copytree(whole.path, output)
    info = json.loads((output / "run.json").read_text())
    info["starts"][-1]["state"] = "running"
    (output / "run.json").write_text(json.dumps(info))

    def resume(*overrides, back=160, **options):
        for path in present(output / "checkpoints"):
            if number_of(path) > back:
                path.unlink()
        options = {"quiet": True, "resume": True} | options
        return pgimp.run(
            folder / "blocks.yaml", output=output, overrides=[EVERY, *overrides], **options
        )

    resume.output = output
    return resume
