"""Inflow: a stream without gaps, of exact mass, momentum and energy; what cannot enter is told."""

import numpy as np
import pytest
from run_files import digests
from scenes import box, field, finish, scene, start

import pgimp
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.solver.sources.inflow import most_at_once

SPEED = 2.0
RAMP = {"ramp": {"from": 0.0, "to": SPEED, "begin": 0.0, "duration": 0.5}}


def stream(dimension=1, *, velocity=None, low=0.0, until=None, **parts):
    """A stream along x, two cells high in 2D, through a region that is two cells long."""
    ends = ([low], [low + 2.0]) if dimension == 1 else ([low, 3.0], [low + 2.0, 5.0])
    case = scene(
        dimension,
        {"jet": box(*ends)},
        cells=[16, 8][:dimension],
        **{"end": 2.0, "step": 0.01} | parts,
    )
    velocity = velocity or [SPEED, 0.0][:dimension]
    case["inflow"] = {"jet": {"velocity": velocity} | ({"until": until} if until else {})}
    return case


@pytest.mark.parametrize("dimension", [1, 2])
@pytest.mark.parametrize(
    "step", [0.01, {"courant": 0.3}, {"courant": "auto"}], ids=["fixed", "courant", "auto"]
)
def test_a_steady_stream_is_a_lattice_that_moves_on(dimension, step):
    """No gap, no overlap, no stress; mass, momentum and energy are those of rho A v t."""
    sim = start(stream(dimension, step=step))
    sim.diagnostics()
    finish(sim)
    x, line = field(sim, "x"), sim.diagnostics()
    rows = np.unique(np.round(x[:, 0], 9))
    assert np.diff(rows) == pytest.approx(0.5, abs=1e-9)
    assert rows[-1] == pytest.approx(1.75 + SPEED * 2.0, abs=1e-9) and rows[0] < 0.75
    assert abs(field(sim, "sigma")).max() < 1e-10
    assert field(sim, "v")[:, 0] == pytest.approx(SPEED, rel=1e-12)
    height = 1.0 if dimension == 1 else 2.0
    layer = 0.5 * height  # mass of a layer
    entered = line["inflow.mass"]
    assert entered == pytest.approx(height * SPEED * 2.0, abs=layer * 1e-12)
    assert line["mass"] == pytest.approx(2.0 * height + entered, rel=1e-15)
    assert line["inflow.momentum-x"] == pytest.approx(SPEED * entered, rel=1e-14)
    assert line["inflow.kinetic-energy"] == pytest.approx(0.5 * SPEED**2 * entered, rel=1e-14)
    assert line["inflow.strain-energy"] == 0.0
    assert abs(line["dissipated-energy"]) < 1e-10 and abs(line["external-work"]) < 1e-10
    assert np.array_equal(np.sort(sim.particles.id[sim.live()]), np.arange(sim.count))


@pytest.mark.parametrize(
    ("low", "velocity"), [(14.0, [-SPEED]), (6.0, [SPEED])], ids=["from-above", "inside"]
)
def test_it_enters_from_either_side_and_within_the_domain(low, velocity):
    sim = finish(start(stream(low=low, velocity=velocity)))
    x = np.sort(field(sim, "x")[:, 0])
    assert len(x) == 12 and np.diff(x) == pytest.approx(0.5, abs=1e-9)
    front = x[-1] if velocity[0] > 0 else x[0]
    at = low + 1.0 + np.sign(velocity[0]) * 0.75
    assert front == pytest.approx(at + velocity[0] * 2.0, abs=1e-9)


def test_what_leaves_again_needs_no_memory():
    """A stream for ever begins, as it leaves: at most two full domains are counted."""
    case = stream(outflow={"x-max": "remove"}, end=1e9, step={"courant": 0.3})
    sim = start(case)
    for _ in range(600):
        sim.advance()
    line = sim.diagnostics()
    assert line["outflow.mass"] > 4.0
    total = line["mass"] - line["inflow.mass"] + line["outflow.mass"]
    assert total == pytest.approx(2.0, abs=1e-12)  # its region was full at the start
    assert most_at_once(sim.case, np.array([[4]]), {"jet": 10**12}) == 2 * 32


def test_a_round_jet_brings_its_area():
    """Along the axis of an axisymmetric case: pi r^2 v t."""
    case = scene(
        2, {"jet": box([0.0, 0.0], [2.0, 2.0])}, cells=[4, 8], geometry="axisymmetric",
        inflow={"jet": {"velocity": [0.0, SPEED]}}, end=1.0,
    )  # fmt: skip
    line = finish(start(case)).diagnostics()
    assert line["inflow.mass"] == pytest.approx(np.pi * 4.0 * SPEED, rel=1e-12)
    assert line["inflow.momentum-y"] == pytest.approx(SPEED * line["inflow.mass"], rel=1e-12)


def test_stages_leave_an_inflow_as_it_is():
    """It ends before its body goes; the constraint that holds it stays."""
    case = stream()
    case["bodies"]["rests"] = box([8.0], [9.0])
    for change, words in (
        ({"remove": ["jet"]}, "time.stages.0.remove.0: 'jet' still enters then; give its inflow"),
        ({"constraints": {"jet": None}}, "time.stages.0.constraints.jet: is that of an inflow"),
        ({"add": ["jet"]}, "time.stages.0.add.0: 'jet' enters by an inflow, which begins"),
    ):
        case["time"]["stages"] = [{"name": "next", "end": 3.0} | change]
        with pytest.raises(CaseError) as error:
            pgimp.load(case)
        assert words in str(error.value)
    case["inflow"]["jet"]["until"] = 2.0
    case["time"]["stages"] = [{"name": "next", "end": 2.5, "remove": ["jet"]}]
    line = finish(start(case)).diagnostics()
    assert (line["mass"], line["removed.mass"]) == (1.0, 2.0 + line["inflow.mass"])


def test_a_velocity_over_time_brings_its_integral():
    """To one layer; distances of layers are those at which they entered."""
    case = stream(velocity=[RAMP])
    sim = start(case)
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        due = sim.case.inflow["jet"].travel(sim.time)
        assert -1e-9 < due + 0.01 * SPEED - line["inflow.mass"] < 0.5 + 0.02 * SPEED
    inside = np.sort(field(sim, "x")[:, 0])[:4]
    assert np.diff(inside) == pytest.approx(0.5, abs=1e-9)


def test_what_is_in_the_region_is_held_and_what_has_left_it_is_free():
    """A wall far away stops the stream: in the region it still has its velocity."""
    case = stream(boundaries={"x-max": "slip"}, end=1.5)
    case["grid"] = {"size": [5.0], "cell": [1.0]}
    sim = start(case)
    before = sim.diagnostics()
    line = finish(sim).diagnostics()
    x, v = field(sim, "x")[:, 0], field(sim, "v")[:, 0]
    assert (v[x < 2.0] == SPEED).all() and v[x > 4.0].max() < 0.5 * SPEED
    # The momentum that entered is still there, but for what the wall and the inflow gave.
    given = 1.5 * (line["constraint.jet-x"] + line["reaction.x-max-x"])
    gained = line["momentum-x"] - before["momentum-x"] - line["inflow.momentum-x"]
    assert given == pytest.approx(gained, rel=1e-11) and line["constraint.jet-x"] > 0.0


def test_it_ends():
    """What was in the region then falls like the rest."""
    sim = start(stream(until=1.0, gravity=[1.0]))
    while sim.time < 1.0 - 1e-9:
        sim.advance()
    before = sim.diagnostics()
    line = finish(sim).diagnostics()
    assert line["inflow.mass"] == before["inflow.mass"] == 1.5  # the next layer was to come then
    assert not sim.particles.constraint[sim.live()].any()
    gained = line["momentum-x"] - before["momentum-x"]
    assert gained == pytest.approx(line["mass"] * 1.0, rel=1e-12)


def test_a_run_goes_on_with_the_same_bits(tmp_path):
    options = {"comm": Serial(), "quiet": True}
    parts = {"output": {"every": 0.25}, "history": {"every": {"steps": 7}}}
    stages = [{"name": "on", "end": 1.7, "gravity": [0.5]}, {"name": "last", "end": 2.4}]
    case = stream(end=1.03, step={"courant": 0.3}, **parts)
    case["time"]["stages"] = stages
    whole = pgimp.run(case, output=tmp_path / "whole", **options)
    for n in range(3):
        case["time"]["stages"] = stages[:n]
        part = pgimp.run(case, output=tmp_path / "parts", resume=bool(n), **options)
    assert digests(part.path) == digests(whole.path)
    followed = whole.follow(6)  # of the second layer that has entered
    assert 0.25 < followed["time"][0] < followed["time"][-1] == 2.4
    written = pgimp.load(whole.path / "case.yaml")  # the case as resolved runs again
    assert written.constraints["jet"].velocity == (SPEED,)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"inflow": {"je": {"velocity": [1.0]}}}, "inflow.je: unknown body 'je'; did you mean"),
        ({"inflow": {"jet": {"velocity": [0.0]}}}, "inflow.jet.velocity: one component, and no"),
        (
            {"inflow": {"jet": {"velocity": [{"table": [[0.0, 1.0], [1.0, -1.0]]}]}}},
            "inflow.jet.velocity: changes its sign",
        ),
        ({"bodies": {"jet": box([0.1], [2.0])}}, "bodies.jet.region.box.min.0: an inflow begins"),
        ({"bodies": {"jet": box([0.0], [0.5])}}, "bodies.jet.region: an inflow is at least a cell"),
        ({"boundaries": {"x-min": "slip"}}, "boundaries.x-min: 'jet' enters here or within two"),
        (
            {"boundaries": {"x-min": "periodic", "x-max": "periodic"}},
            "inflow.jet.velocity: along x the domain is periodic",
        ),
        (
            {"bodies": {"jet": box([0.0], [2.0]) | {"formulation": "total-lagrangian"}}},
            "bodies.jet.formulation: the grid of the initial configuration moves",
        ),
        (
            {"tractions": {"t": {"body": "jet", "face": "x-max", "pressure": 1.0}}},
            "tractions.t.body: 'jet' enters by an inflow",
        ),
        ({"start": {"equilibrate": {}}}, "inflow.jet: does not come to rest, as settle looks for"),
        (
            {"bodies": {"jet": box([0.0], [2.0]), "wall": box([1.0], [4.0])}},
            "bodies.wall.region: 'jet' and 'wall' overlap",
        ),
    ],
)
def test_what_cannot_enter_is_told(change, words):
    with pytest.raises(CaseError) as error:
        start_of = pgimp.load(stream() | change)
        start(start_of.model_dump(by_alias=True))
    assert words in str(error.value)


def test_the_ground_has_the_stress_of_its_weight_and_what_enters_none():
    case = scene(
        2, {"ground": box([0.0, 0.0], [4.0, 2.0]), "rain": box([1.0, 5.0], [3.0, 6.0])},
        cells=[4, 6], gravity=[0.0, -1.0], start={"stress": {"k0": 0.5}}, end=0.01,
        boundaries={"x-min": "slip", "x-max": "slip", "y-min": "slip"},
        inflow={"rain": {"velocity": [0.0, -1.0]}},
    )  # fmt: skip
    sim = finish(start(case))
    sigma = field(sim, "sigma")
    assert abs(sigma[32:]).max() < 0.01 and sigma[:32, 1].min() < -1.5


@pytest.mark.parametrize("seed", range(6))
def test_random_streams_are_lattices(seed):
    """Whatever the speed, the steps, the region and its end: no gap, and the mass that is due."""
    rng = np.random.default_rng(seed)
    per_cell, sign = int(rng.integers(1, 4)), float(rng.choice([-1.0, 1.0]))
    speed, length = sign * float(rng.uniform(0.5, 3.0)), float(rng.integers(1, 4))
    low = 20.0 + int(rng.integers(0, per_cell)) / per_cell
    cell = float(rng.choice([0.5, 1.0]))
    until = None if rng.random() < 0.5 else float(rng.uniform(0.5, 1.5))
    case = scene(
        1, {"jet": box([low * cell], [(low + length) * cell])}, cells=[44], cell=cell,
        per_cell=per_cell, end=2.0, step=float(rng.choice([0.01, 0.02])),
        inflow={"jet": {"velocity": [speed], "until": until}},
    )  # fmt: skip
    sim = start(case)
    first = sim.count
    finish(sim)
    x, spacing = np.sort(field(sim, "x")[:, 0]), cell / per_cell
    assert np.diff(x) == pytest.approx(spacing, abs=1e-9)
    front = (low + length if sign > 0.0 else low) * cell - sign * 0.5 * spacing + speed * 2.0
    assert (x[-1] if sign > 0.0 else x[0]) == pytest.approx(front, abs=1e-9)
    way = abs(speed) * min(2.0, until or 2.0)
    assert sim.count - first == pytest.approx(way / spacing, abs=1.0 + 1e-6)
    assert sim.diagnostics()["inflow.mass"] == pytest.approx((sim.count - first) * spacing)
