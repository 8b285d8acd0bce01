"""The tutorials do what they say: each is followed from an empty folder, and its numbers hold.

A run has the same bits on one type of CPU. On others rounding differs, so numbers are compared to
their last digit or 2 %; those of a wave that breaks, where rounding decides what splashes, to 10 %.
Numbers in sentences are compared as well, each with what the runs have.
"""

import re
import shlex
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO

import numpy as np
import pytest
from pages import ROOT, TUTORIALS
from processes import run
from tutorials.follow import Said, UnexpectedError, alike, environment, expect, follow, grown

import pgimp
from pgimp.cli import main

pytestmark = pytest.mark.slow(20)

TOLERANCE = {"dam-break": 0.1}
SECONDS = 600.0


def start(words, folder):
    """Run a command; one that hangs fails the test.

    Most of pgimp's commands run in this process, which saves their start. What imports code, or
    starts processes itself, has one of its own.
    """
    name, *rest = words
    if name != "pgimp" or rest[0] in ("study", "batch") or "--import" in rest:
        done = run(words, SECONDS, folder, environment())
        return Said(done.returncode, done.stdout + done.stderr)
    said = StringIO()
    with chdir(folder), redirect_stdout(said), redirect_stderr(said):
        status = main(rest)
    return Said(status, said.getvalue())


def followed(page, folder):
    return follow(page, folder, start, TOLERANCE.get(page, 0.02))


def stated(page, sentence):
    """The numbers of a sentence of a page, in which # stands for each."""
    text = " ".join(TUTORIALS[f"docs/tutorials/{page}.md"].split())
    pattern = re.escape(sentence).replace(r"\#", r"(-?\d+(?:\.\d+)?)")
    found = re.search(pattern, text)
    assert found, f"{page}: {sentence}"
    return [float(number) for number in found.groups()]


@pytest.mark.wide
def test_footing(tmp_path):
    followed("footing", tmp_path)
    books = pgimp.open(tmp_path / "footing.out").history
    (sunk,) = stated("footing", "until the strip has sunk by # mm")
    assert -1e3 * books["rigid.strip.displacement-y"][-1] == pytest.approx(sunk, abs=0.5)
    # "The force stays": within a tenth, as the last figure of the page scatters.
    (flat,) = stated("footing", "From # mm on the force stays")
    way, force = -1e3 * books["rigid.strip.displacement-y"], books["rigid.strip.force-y"]
    later = np.convolve(force, np.ones(5) / 5.0, "same")[(way > flat) & (way < 24.0)]
    assert later.max() - later.min() < 0.1 * later.mean()


@pytest.mark.wide
def test_impact(tmp_path):
    followed("impact", tmp_path)
    books = pgimp.open(tmp_path / "impact.out").history
    assert books["kinetic-energy"][-1] < 0.02 * books["kinetic-energy"][0]
    assert books["plastic-work"][-1] > 0.9 * books["kinetic-energy"][0]
    # Errors of the case's cells against the limits that the page shows, to their last digit.
    lines = pgimp.open(tmp_path / "cells.study.out/runs/cell-0.0008").history
    centre, work = lines["body.bar.centre-y"][-1], lines["plastic-work"][-1]
    (high,) = stated("impact", "the centre is # % too high, for an eighth of the work")
    assert 100.0 * (centre / 0.012954 - 1.0) == pytest.approx(high, abs=0.05)
    (less,) = stated("impact", "# % are missing with 0.8 mm")
    assert 100.0 * (1.0 - work / 6967.2) == pytest.approx(less, abs=0.5)
    # Of the bar's foot, as the run's last line has it.
    assert stated("impact", "is stretched to # times its length") == [4.6]


@pytest.mark.wide
def test_dam_break(tmp_path):
    followed("dam-break", tmp_path)
    run = pgimp.open(tmp_path / "dam.out")
    up, time = run.history["rigid.float.displacement-y"], run.history["time"]
    # "The wave reaches the float within half a second, and lifts it": by a tenth of its draught.
    assert 0.3 < time[(up > 0.012).argmax()] < 0.5
    # What the page says of the least steps: sound of water is 70 times as fast as here.
    (times,) = stated("dam-break", "would need steps # times as short")
    assert 1.48e3 / np.sqrt(4.0e5 / 1.0e3) == pytest.approx(times, rel=0.1)


@pytest.mark.wide
def test_hopkinson(tmp_path):
    said = followed("hopkinson", tmp_path)
    # What the page says of the pulse's front is what the script says of the greatest stress.
    found = [
        float(re.search(r"greatest +(\d+) MPa", said[f"python curve.py {name}.out"].text)[1])
        for name in ("lumped", "hopkinson")
    ]
    over = stated("hopkinson", "overshoots by # % with lumped mass, and by # %")
    assert [100.0 * (each / 197.5 - 1.0) for each in found] == pytest.approx(over, abs=1.0)


@pytest.mark.wide
def test_own_material(tmp_path):
    said = followed("own-material", tmp_path)
    (rows,) = (each.text for words, each in said.items() if words.startswith("pgimp element"))
    path = [float(value) for value in re.findall(r"^ +[\d.]+ +(-?[\d.]+)$", rows, re.MULTILINE)]
    (lower,) = stated("own-material", "On the way back the stress is # kPa lower")
    # At the strain 0.02 on both ways: the elastic parts are the same, to what one step adds.
    assert 1e-3 * (path[1] - path[-2]) == pytest.approx(lower, rel=0.02)


@pytest.fixture
def slurm(tmp_path_factory, monkeypatch):
    """A Slurm of two nodes, both this machine; pages tell its commands as any cluster's."""
    folder = tmp_path_factory.mktemp("cluster") / "slurm"
    words = str(ROOT / "scripts" / "slurm")
    done = run([words, "start", str(folder), "2"], 60)
    assert done.returncode == 0, done.stderr
    for name, value in re.findall(r"^export (\w+)=(.*)$", done.stdout, re.MULTILINE):
        monkeypatch.setenv(name, shlex.split(value)[0])
    yield
    run([words, "stop", str(folder)], 60)


@pytest.mark.wide
@pytest.mark.usefixtures("slurm")
def test_batch_job(tmp_path):
    followed("batch-job", tmp_path)
    assert len([*tmp_path.glob("bar-*.log")]) == 1


def test_every_tutorial_is_followed():
    there = {name.rpartition("/")[2].removesuffix(".md").replace("-", "_") for name in TUTORIALS}
    assert {f"test_{name}" for name in there} <= {*globals()}


def test_a_block_replaces_parts_and_adds_others():
    file = "# text\na: 1\nb:\n  c: 2\n  # of c\nd: 3\n"
    assert grown(file, "b: {c: 4}\ne: 5\n") == "# text\na: 1\nb: {c: 4}\nd: 3\ne: 5\n"
    assert grown("", file) == file


def test_lines_are_alike_to_their_last_digit():
    assert alike("at 1.50 m", "at  1.51 m", 0.0) and not alike("at 1.50 m", "at 1.52 m", 0.0)
    assert alike("at 1.50 m", "at 1.52 m", 0.02) and not alike("at 1.50 m", "to 1.50 m", 0.02)
    assert alike("2,470 steps", "2,469 steps", 0.0) and alike("took ... s", "took 3 s", 0.0)
    assert alike("1.0e-05", "1.1e-05", 0.0) and not alike("1.0e-05", "1.2e-05", 0.0)
    expect("one\n...\nthree\n", "one\ntwo\nthree\n", 0.0)
    with pytest.raises(UnexpectedError, match="not said: one"):
        expect("three\none\n", "one\ntwo\nthree\n", 0.0)
