"""Bodies that come in stages: as those of the start, and in the books; in whose place none may be.

Mostly in 1D: a bar, and another that comes beside it.
"""

import re

import numpy as np
import pytest
from meshes import ball, stl
from run_files import digests, go_back
from scenes import box, field, finish, scene, start
from staged_bar import entered

import pgimp
from pgimp.commands import check
from pgimp.errors import CaseError, RunError, UsageError
from pgimp.mpi.comm import Serial

pytestmark = pytest.mark.slow(30)

COMES = {"name": "fill", "end": 1.0, "add": ["comes"]}
#: A stage in which nothing comes, but the one before has this end.
END = 0.5


def bars(*stages, comes=None, **parts):
    """A bar that flies, and another that comes, in 1D."""
    bodies = {"flies": box([0.0], [3.0], [0.3]), "comes": comes or box([8.0], [11.0], [-0.4])}
    case = scene(1, bodies, cells=[16], end=END, step=0.01, **parts)
    case["time"]["stages"] = list(stages)
    return case


def test_a_body_that_comes_moves_as_if_the_run_began_then():
    """Bit for bit, where it meets nothing; the numbers of its particles follow those before."""
    late = finish(start(bars(COMES)))
    alone = scene(1, box([8.0], [11.0], [-0.4]), cells=[16], end=0.5, step=0.01)
    # Away from the walls it vibrates, as a body that begins to move does.
    alone["gravity"] = later = [1.0]
    pushed = bars(COMES | {"gravity": later})
    late, early = finish(start(pushed)), finish(start(alone))
    new = np.sort(late.particles.id[late.live()])[-6:]
    assert list(new) == [6, 7, 8, 9, 10, 11] and late.count == 12
    for name in ("x", "v", "F", "sigma", "V"):
        assert np.array_equal(field(late, name)[6:], field(early, name)), name


def test_the_books_have_what_comes():
    sim, before = entered(bars(COMES, gravity=[-0.2]))
    now = sim.diagnostics()
    assert before["added.mass"] == 0.0 and now["added.mass"] == 3.0
    assert now["mass"] == before["mass"] + 3.0
    assert now["added.momentum-x"] == pytest.approx(-1.2, rel=1e-15)
    assert now["added.kinetic-energy"] == pytest.approx(0.24, rel=1e-14)
    assert now["added.strain-energy"] == 0.0
    assert now["dissipated-energy"] == pytest.approx(before["dissipated-energy"], abs=1e-14)
    assert before["body.comes.mass"] == 0.0 and np.isnan(before["body.comes.centre-x"])
    assert now["body.comes.centre-x"] == pytest.approx(9.5, rel=1e-15)
    end = finish(sim).diagnostics()
    gained = end["momentum-x"] - before["momentum-x"] - end["added.momentum-x"]
    assert gained == pytest.approx(-0.2 * 6.0 * 0.5, rel=1e-12)
    assert end["mass"] == 6.0


@pytest.mark.parametrize(("low", "fits"), [(2.9, False), (3.3, True)], ids=["overlap", "a-little"])
def test_none_comes_in_the_place_of_particles(low, fits):
    """The bar's last particle is at 2.9 by then; a region that it reaches a little is none."""
    case = bars(COMES, comes=box([low - 0.5], [6.0]))
    sim = start(case)
    while not sim.stage_done:
        sim.advance()
    if fits:
        sim.next_stage()
        assert sim.present() == 6 + 7
        return
    x, count = field(sim, "x"), sim.count
    with pytest.raises(RunError) as error:
        sim.next_stage()
    text = str(error.value)
    assert "stage 'fill': body 'comes' cannot come: 'flies' has a particle there, at (2." in text
    assert "remove what is in its place" in text
    assert np.array_equal(field(sim, "x"), x) and sim.count == count and sim.stage == 0


def test_a_body_may_come_in_the_place_of_one_that_goes():
    stages = COMES | {"remove": ["flies"]}, {"name": "on", "end": 1.2}
    sim = finish(start(bars(*stages, comes=box([0.0], [3.0], [0.3]))))
    line = sim.diagnostics()
    assert (line["removed.mass"], line["added.mass"], line["mass"]) == (3.0, 3.0, 3.0)


def test_none_comes_into_a_rigid_body():
    case = bars(COMES, contact=[{"bodies": "all"}])
    case["bodies"]["tool"] = {"rigid": {}, "region": {"box": {"min": [10.0], "max": [13.0]}}}
    sim = start(case)
    while not sim.stage_done:
        sim.advance()
    with pytest.raises(RunError, match=r"'comes' cannot come: it would be in the rigid 'tool' at"):
        sim.next_stage()


def test_what_is_declared_for_a_body_waits_for_it():
    """A constraint holds its particles, and a traction acts on the whole face."""
    case = bars(
        COMES,
        constraints={"grip": {"body": "comes", "region": {"box": {"min": [10.0], "max": [11.0]}},
                              "velocity": [0.5]}},
        tractions={"push": {"body": "comes", "face": "x-min", "pressure": 2.0}},
        comes=box([8.0], [11.0]),
    )  # fmt: skip
    sim, _ = entered(case)
    finish(sim)
    assert (field(sim, "v")[-2:, 0] == 0.5).all()
    line = sim.diagnostics()
    # What the grip gave is all that its body has, less what the pressure on the face gave.
    assert line["external-work"] > 0.0
    other = bars(COMES, tractions=case["tractions"], comes=box([8.0], [11.0]))
    line = finish(start(other)).diagnostics()
    assert line["body.comes.momentum-x"] == pytest.approx(2.0 * 0.5, rel=1e-12)


def test_a_lift_has_the_stress_of_its_own_weight():
    case = scene(
        2,
        {"ground": box([0.0, 0.0], [4.0, 2.0]), "lift": box([0.0, 2.0], [4.0, 4.0])},
        cells=[4, 8], end=0.1, gravity=[0.0, -1.0], start={"stress": {"k0": 0.5}},
        boundaries={"x-min": "slip", "x-max": "slip", "y-min": "slip"},
    )  # fmt: skip
    case["materials"]["soft"] |= {"model": "hooke"}
    case["time"]["stages"] = [{"name": "fill", "end": 0.2, "add": ["lift"]}]
    sim, _ = entered(case)
    x, sigma = field(sim, "x")[32:], field(sim, "sigma")[32:]
    assert sigma[:, 1] == pytest.approx(x[:, 1] - 4.0, rel=1e-12)
    assert sigma[:, 0] == pytest.approx(0.5 * sigma[:, 1], rel=1e-12)


def test_a_run_goes_on_after_a_body_has_come_with_the_same_bits(tmp_path):
    """Frames grow as it comes. A body that was there cannot come in the run that goes on."""
    options = {"comm": Serial(), "quiet": True}
    further = {"name": "on", "end": 1.3}
    case = bars(COMES, further, output={"every": 0.25})
    whole = pgimp.run(case, output=tmp_path / "whole", **options)
    pgimp.run(bars(COMES, output={"every": 0.25}), output=tmp_path / "parts", **options)
    parts = pgimp.run(case, output=tmp_path / "parts", resume=True, **options)
    assert digests(parts.path) == digests(whole.path)
    counts = [len(frame["id"]) for frame in whole]
    assert counts[0] == 6 and counts[-1] == 12 and counts == sorted(counts)

    pgimp.run(bars(output={"every": 0.25}), output=tmp_path / "there", **options)
    with pytest.raises(UsageError, match=r"add: awaited .*comes.*, was "):
        pgimp.run(case, output=tmp_path / "there", resume=True, **options)


def test_a_body_from_a_file_comes_also_in_a_run_that_goes_on(tmp_path):
    """Killed before it comes, and after; the file is read again as it comes."""
    stl(tmp_path / "ball.stl", ball(2, 1.0, (2.0, 2.0, 3.0)))
    bodies = {
        "rests": box([0.0] * 3, [4.0, 4.0, 1.0]),
        "comes": {"material": "soft", "region": {"mesh": {"file": str(tmp_path / "ball.stl")}},
                  "velocity": [0.0, 0.0, -1.0]},
    }  # fmt: skip
    often = {"every": {"steps": 1}, "keep": 10}
    case = scene(3, bodies, cells=[4, 4, 6], end=0.02, step=0.01, checkpoint=often)
    case["time"]["stages"] = [
        {"name": "wait", "end": 0.04}, {"name": "fill", "end": 0.06, "add": ["comes"]},
    ]  # fmt: skip
    options = {"comm": Serial(), "quiet": True}
    whole = pgimp.run(case, output=tmp_path / "whole", **options)
    assert whole.history["added.mass"][-1] == pytest.approx(4.0 / 3.0 * np.pi, rel=0.1)
    pgimp.run(case, output=tmp_path / "parts", **options)
    go_back(tmp_path / "parts", 0.3)
    parts = pgimp.run(case, output=tmp_path / "parts", resume=True, **options)
    assert digests(parts.path) == digests(whole.path)
    assert 0 < parts.info["resumed_from"] < 4


def test_check_tells_what_comes(capsys):
    check.report(pgimp.load(bars(COMES)))
    said = capsys.readouterr().out
    assert "'fill' to t = 1, 50 steps; changes add comes" in said
    assert re.search(r"body comes +6 particles", said)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"add": ["come"]}, "time.stages.0.add.0: unknown body 'come'; did you mean 'comes'?"),
        ({"add": ["comes", "comes"]}, "time.stages.0.add.1: 'comes' has come in the stage 'fill'"),
        ({"remove": ["comes"]}, "time.stages.0.remove.0: 'comes' comes in this stage"),
        (
            {"add": ["comes", "flies", "lasting"]},
            "time.stages.0.add: then no body is there from the start",
        ),
        ({"add": ["tool"]}, "time.stages.0.add.0: 'tool' is rigid"),
        ({"add": ["lasting"]}, "time.stages.0.add.0: 'lasting' is in the initial configuration"),
    ],
)
def test_what_cannot_come_is_told(change, words):
    case = bars(COMES | change)
    case["bodies"]["tool"] = {"rigid": {}, "region": {"box": {"min": [14.0], "max": [15.0]}}}
    case["bodies"]["lasting"] = box([12.0], [13.0]) | {"formulation": "total-lagrangian"}
    case["contact"] = [{"bodies": "all"}]
    with pytest.raises(CaseError) as error:
        pgimp.load(case)
    assert words in str(error.value)


def test_a_probe_follows_what_is_there_from_the_start():
    with pytest.raises(CaseError, match=r"probes\.p\.body: 'comes' comes in the stage 'fill'"):
        pgimp.load(bars(COMES, probes={"p": {"body": "comes", "at": [9.0]}}))


def test_a_body_that_comes_later_must_have_particles():
    with pytest.raises(CaseError, match=r"bodies\.comes\.region: contains no particle"):
        start(bars(COMES, comes=box([8.0], [8.2]) | {"surface": "whole-particles"}))
