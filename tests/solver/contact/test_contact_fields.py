"""Velocity fields of bodies that may meet: those that cannot yet share one."""

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from run_files import digests
from scenes import box, field, finish, scene, start, write_case

import pgimp
from pgimp.case.schema import Case
from pgimp.errors import DamagedError
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.io.checkpoints.checkpointwriter import write
from pgimp.mpi.comm import Serial
from pgimp.solver.contact import multifield
from pgimp.solver.contact.velocity_fields import (
    MARGIN,
    MOST,
    assign,
    body_boxes,
    margin_of,
    where_near,
)
from pgimp.solver.simulation import Simulation

#: Boxes of up to eight bodies in a plane, in cells.
BOXES = some.lists(
    some.tuples(*[some.floats(0.0, 60.0)] * 2, *[some.floats(0.1, 12.0)] * 2),
    min_size=1,
    max_size=8,
)


@given(BOXES, some.floats(1.0, 4.0))
@settings(deadline=None)
def test_bodies_that_share_a_field_cannot_meet(bodies, reach):
    """Not before the next search, if both move by the margin towards each other."""
    table = np.array(bodies)
    boxes = np.stack([table[:, :2], table[:, :2] + table[:, 2:]])
    wide, fields = 2.0 * MARGIN + reach, assign(boxes, reach)
    assert MARGIN <= margin_of(boxes, reach, fields) <= MOST
    for a in range(len(bodies)):
        for b in range(a):
            apart = max(
                max(boxes[0, a, d] - boxes[1, b, d], boxes[0, b, d] - boxes[1, a, d])
                for d in (0, 1)
            )
            if fields[a] == fields[b]:
                assert apart - 2.0 * MARGIN >= reach
    # No field is left out, and one is enough for bodies that are far apart.
    assert set(fields) == set(range(max(fields) + 1))
    # In which planes those of different fields may share vertices meanwhile.
    ends, far = where_near(boxes, wide, fields), 0.5 * wide
    for plane in np.arange(-80.0, 150.0, 1.7):
        for a in range(len(bodies)):
            for b in range(a):
                apart = boxes[0, [a, b]] - boxes[1, [b, a]] - 2.0 * far
                both = (boxes[0, [a, b], 0] - far <= plane) & (plane <= boxes[1, [a, b], 0] + far)
                if fields[a] != fields[b] and both.all() and (apart < 0.0).all():
                    assert ((ends[:, 0] <= plane) & (plane <= ends[:, 1])).any()


def plain_fields(boxes, reach):
    """Fields and intervals as `assign` and `where_near`, in NumPy."""
    low, high = boxes
    apart = np.full((len(low),) * 2, -np.inf)
    for d in range(low.shape[1]):
        np.maximum(apart, low[:, None, d] - high[None, :, d], out=apart)
    apart = np.maximum(apart, apart.T)
    fields, wide = np.zeros(len(low), int), 2.0 * MARGIN + reach
    for b in range(len(low)):
        taken = set(fields[:b][apart[b, :b] < wide].tolist())
        fields[b] = min(set(range(b + 1)) - taken)
    a, b = np.triu_indices(len(low), 1)
    near = apart[a, b] < wide
    a, b = a[near], b[near]
    ends = [np.maximum(low[a, 0], low[b, 0]) - 0.5 * wide,
            np.minimum(high[a, 0], high[b, 0]) + 0.5 * wide]  # fmt: skip
    return tuple(fields.tolist()), np.stack(ends, axis=1)


def ordered(intervals):
    """Intervals in an order of their own."""
    return intervals[np.lexsort(intervals.T)]


@pytest.mark.parametrize("seed", range(20))
def test_fields_of_hundreds_of_bodies_are_those_of_numpy(seed):
    """Heaps and sparse grains, in 1D to 3D, also bodies of which no particle is left."""
    random = np.random.default_rng(seed)
    D, count = 1 + seed % 3, int(random.integers(1, 300))
    low = random.uniform(0.0, random.choice([8.0, 60.0, 400.0]), (count, D))
    boxes = np.stack([low, low + random.uniform(0.5, 6.0, (count, D))])
    empty = random.random(count) < 0.1
    boxes[0, empty], boxes[1, empty] = np.inf, -np.inf
    reach = float(random.uniform(2.0, 4.0))
    fields, ends = plain_fields(boxes, reach)
    assert assign(boxes, reach) == fields
    found = where_near(boxes, 2.0 * MARGIN + reach, fields)
    np.testing.assert_array_equal(ordered(found), ordered(ends))


def test_bodies_apart_share_a_field():
    bodies = {
        "left": box([2.0, 2.0], [5.0, 5.0], [1.0, 0.0]),
        "right": box([18.0, 2.0], [21.0, 5.0], [-1.0, 0.0]),
    }
    case = scene(2, bodies, cells=[26, 8], end=2.5, contact=[{"bodies": "all"}])
    sim, counts = start(case), []
    while not sim.finished:
        sim.advance()
        counts.append(1 + max(sim.rank.contact.fields))
    assert counts[0] == 1
    case["bodies"]["right"]["velocity"] = [-5.0, 0.0]
    sim = start(case | {"time": {"end": 2.5, "step": 0.01}})
    while 1 + max(sim.rank.contact.fields) == 1:
        sim.advance()
    assert sim.diagnostics()["contact.all.normal-impulse"] == 0.0
    assert finish(sim).diagnostics()["contact.all.normal-impulse"] > 0.0


def falling(end, **parts):
    """Many squares that fall on each other, each with a velocity of its own, numbered anyhow."""
    random, bodies = np.random.default_rng(1), {}
    for n in range(36):
        low = 2.2 * np.array([n % 6, n // 6]) + [0.2 + 1.1 * (n // 6 % 2), 0.1]
        velocity = random.uniform([-3.0, -3.0], [3.0, 0.0]).tolist()
        bodies[f"g{n}"] = box(low.tolist(), (low + 2.0).tolist(), velocity)
    names = [str(name) for name in random.permutation([*bodies])]
    return scene(
        2, {name: bodies[name] for name in names}, cells=[15, 17], end=end,
        gravity=[0.0, -2.0], contact=[{"bodies": "all", "friction": 0.3}],
        boundaries={"y-min": "unilateral", "x-min": "slip", "x-max": "slip"}, **parts,
    )  # fmt: skip


def assigned_now(sim):
    """The fields that bodies would have where they are now."""
    contact = sim.rank.contact
    return assign(boxes_now(sim.rank), contact._reach)


def boxes_now(rank):
    """Boxes of the bodies where they are now."""
    particles, rows = rank.population.up_to_date(), rank.population.order
    return body_boxes(rank.scene.domain, particles, rows, len(rank.scene.body_names), rank.comm)


@pytest.mark.parametrize(("speed", "most"), [(0.02, 1), (0.3, 5)])
def test_bodies_of_a_field_are_apart_in_every_step(monkeypatch, speed, most):
    """Slow ones, for which there are few searches, and ones as fast as steps allow."""
    usual, searches = multifield.assign, []

    def look(boxes, reach):
        searches.append(len(searches))
        return usual(boxes, reach)

    monkeypatch.setattr(multifield, "assign", look)
    case = falling(0.1)
    case["time"]["step"] = 1e-3
    case["grid"] |= {"origin": [0.0, -5.0], "size": [15.0, 27.0]}
    for n, body in enumerate(case["bodies"].values()):
        body["velocity"] = [0.0, speed * (-1) ** n * 1e3]
    sim = start(case | {"contact": [{"bodies": "all", "law": "ignore"}], "boundaries": {}})
    for _ in range(12):
        sim.rank.contact.assign_fields(sim.rank)
        boxes, fields = boxes_now(sim.rank), np.array(sim.rank.contact.fields)
        apart = np.maximum(boxes[0][:, None] - boxes[1][None], boxes[0][None] - boxes[1][:, None])
        alone = apart.max(axis=2) >= sim.rank.contact._reach
        same = (fields[:, None] == fields) & ~np.eye(len(fields), dtype=bool)
        assert alone[same].all()
        sim.advance()
    assert 1 <= len(searches) <= most


@pytest.mark.parametrize(("count", "most"), [(2, 1e-6), (3, 1.0)])
def test_the_order_of_the_fields_matters(monkeypatch, count, most):
    """Why checkpoints have them: filled parts are rounded as they add up, and sweeps have an order.

    Those over the pairs of three bodies at a vertex end before the order is forgotten.
    """
    bodies = {
        "left": box([2.0, 0.0], [5.3, 3.2], [1.0, 0.0]),
        "right": box([5.3, 0.0], [9.0, 3.2], [-1.0, 0.0]),
        "top": box([3.6, 3.2], [7.2, 6.0], [0.3, -2.0]),
    }
    case = scene(
        2, dict([*bodies.items()][:count]), cells=[12, 10], end=0.2,
        contact=[{"bodies": "all", "friction": 0.3}],
    )  # fmt: skip
    found = []
    for turned in (False, True):

        def numbered(boxes, reach, turned=turned):
            fields = assign(boxes, reach)
            return tuple(max(fields) - f if turned else f for f in fields)

        monkeypatch.setattr(multifield, "assign", numbered)
        found.append(field(finish(start(case)), "v"))
    assert 0.0 < np.abs(found[1] - found[0]).max() < most


@pytest.mark.slow(20)
def test_a_resumed_heap_leaves_the_same_bytes(tmp_path):
    """Where bodies would have other fields by now; at some such steps others had other bits."""
    case = falling(0.6, output={"every": 0.25, "fields": ["velocity"]},
                   history={"every": {"steps": 1}})  # fmt: skip
    sim, others = start(case), []
    while not sim.finished:
        sim.advance()
        others += [sim.step] * (sim.step > 30 and assigned_now(sim) != sim.rank.contact.fields)
    write_case(tmp_path / "case.yaml", case)
    often = ["checkpoint={every: {steps: 1}, keep: 100}"]
    pgimp.run(tmp_path / "case.yaml", output=tmp_path / "whole", overrides=often, quiet=True)
    whole = digests(tmp_path / "whole")
    assert len(others) >= 4
    for step in others[:4]:
        output = tmp_path / str(step)
        shutil.copytree(tmp_path / "whole", output)
        for checkpoint in (output / "checkpoints").iterdir():
            if checkpoint.stem != f"step-{step:09d}":
                checkpoint.unlink()
        info = output / "run.json"
        info.write_text(info.read_text().replace('"state": "done"', '"state": "running"'))
        run = pgimp.run(tmp_path / "case.yaml", output=output, resume=True, quiet=True)
        assert run.info["resumed_from"] == step
        assert digests(output) == whole


def test_a_checkpoint_without_fields_is_of_an_older_version(tmp_path):
    """They are assigned anew, which changes bits only; fields that cannot be are refused."""
    write_case(tmp_path / "case.yaml", falling(0.3))
    run = pgimp.run(tmp_path / "case.yaml", output=tmp_path / "run", quiet=True)
    (path,) = (run.path / "checkpoints").iterdir()
    file = CheckpointFile(path)
    rows = {name: file.read(name, 0, file.count) for name in file.rows}
    whole = {name: file.read_whole(name) for name in file.whole}
    fields = whole.pop("velocity-fields")
    sim = Simulation(Case.model_validate(falling(0.4)), Serial(), file)
    assert (sim.rank.contact.assignment == fields).all()
    write(path, Serial(), file.about, rows, whole)
    sim = Simulation(Case.model_validate(falling(0.4)), Serial(), CheckpointFile(path))
    finish(sim)
    for change in (fields[:-1], fields + 25, fields - 2, fields.astype(float)):
        write(path, Serial(), file.about, rows, whole | {"velocity-fields": change})
        with pytest.raises(DamagedError, match=r"velocity.fields"):
            Simulation(Case.model_validate(falling(0.4)), Serial(), CheckpointFile(path))


def test_frames_of_contact_leave_the_fields_as_they_are(tmp_path):
    """They are assigned before the same steps, whatever is written in between."""
    found = []
    for every in (1, 7):
        output = {"every": {"steps": every}, "fields": ["velocity"], "grid": ["contact"]}
        write_case(tmp_path / "case.yaml", falling(0.7, output=output))
        run = pgimp.run(tmp_path / "case.yaml", output=tmp_path / str(every), quiet=True)
        found.append(run.frame(-1)["velocity"].tobytes())
    assert found[0] == found[1]
