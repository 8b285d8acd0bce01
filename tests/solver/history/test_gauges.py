"""Gauges against statics, and sums of particles. On any ranks: tests/proofs/test_ranks.py."""

import numpy as np
import pytest
from region_entries import half_space as half
from scenes import box, scene, start

import pgimp
from pgimp.utilities.plot.units import kind_of_column

WALLS = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}
WATER = {"model": "newtonian", "bulk": 1.0e4, "shear-viscosity": 1.0, "density": 1.0}


GAUGES = {
    "waist": {"cut": half([2.0, 2.5], [0.0, 1.0])},
    "upper": {"cut": half([2.0, 2.5], [0.0, -1.0])},
    "block": {"cut": {"box": {"min": [1.0, 1.0], "max": [3.0, 3.5]}}},
    "floor": {"wall": "y-min"},
    "left": {"wall": "y-min", "within": {"box": {"min": [0.0, 0.0], "max": [1.0, 4.0]}}},
    "right": {"wall": "y-min", "within": {"box": {"min": [1.0, 0.0], "max": [4.0, 4.0]}}},
    "side": {"wall": "x-max"},
    "depth": {"level": [1.7]},
    "edge": {"level": [0.0]},
}


@pytest.fixture(scope="module")
def column():
    """A column of soft solid, at rest under its weight, and the sums over its particles."""
    case = scene(
        2,
        box([0.0, 0.0], [4.0, 5.0]),
        cells=[4, 8],
        gravity=[0.0, -0.2],
        boundaries=WALLS,
        start={"equilibrate": {"tolerance": 1e-7}},
        damping={"kinetic": True},
        gauges=GAUGES,
    )
    sim = pgimp.Simulation(case)
    return sim.diagnostics(), sim.particles


def test_a_cut_bears_the_weight_above_it(column):
    """In the middle of a cell the vertices above have the mass of the weights of GIMP's tents."""
    line, particles = column
    y, mass = particles["position"][:, 1], particles["mass"]
    # Mass above: each particle's part in the vertices from y = 3 on; boxes of half a cell.
    edges = np.array([-0.25, 0.25])
    fine = np.mean([np.clip(y + e - 2.0, 0.0, 1.0) for e in np.linspace(*edges, 2001)], axis=0)
    weight = 0.2 * mass @ fine
    assert line["gauge.waist.force-y"] == pytest.approx(-weight, rel=1e-4)
    assert weight == pytest.approx(0.2 * 10.0, rel=0.05)
    assert line["gauge.waist.force-x"] == pytest.approx(0.0, abs=1e-9)
    assert line["gauge.waist.moment-z"] == pytest.approx(0.0, abs=1e-6)
    for name in ("force-x", "force-y", "moment-z"):  # action and reaction, to rounding
        assert line[f"gauge.upper.{name}"] == pytest.approx(-line[f"gauge.waist.{name}"], abs=1e-12)


def test_a_box_is_held_up_by_its_weight(column):
    line, particles = column
    x, y, mass = *particles["position"][:, :2].T, particles["mass"]
    inside = (np.abs(x - 2.0) < 1.0) & (y > 1.0) & (y < 3.5)
    assert line["gauge.block.force-y"] == pytest.approx(0.2 * mass[inside].sum(), rel=0.03)
    assert line["gauge.block.force-x"] == pytest.approx(0.0, abs=1e-9)


def test_walls_bear_what_their_reactions_are(column):
    """Also that of a part: here of the first quarter of a wall under the same pressure."""
    line, particles = column
    weight = 0.2 * particles["mass"].sum()
    assert line["gauge.floor.force"] == pytest.approx(weight, rel=1e-5)
    assert line["gauge.floor.pressure"] == pytest.approx(weight / 4.0, rel=1e-5)
    parts = [line[f"gauge.{name}.force"] for name in ("left", "right")]
    assert sum(parts) == pytest.approx(line["gauge.floor.force"], rel=1e-12)
    assert parts[0] == pytest.approx(0.25 * weight, rel=1e-4)
    assert line["gauge.left.pressure"] == pytest.approx(line["gauge.right.pressure"], rel=1e-4)
    sideways = particles["stress"][:, 0] @ particles["volume"] / 4.0
    assert line["gauge.side.force"] == pytest.approx(-sideways, rel=1e-3)


def test_a_level_is_volume_over_area(column):
    line, particles = column
    height = particles["volume"].sum() / 4.0
    assert 4.97 < height < 4.99
    for name in ("depth", "edge"):
        assert line[f"gauge.{name}.height"] == pytest.approx(height, rel=1e-4)
        assert line[f"gauge.{name}.top"] == pytest.approx(height, rel=2e-3)


def test_water_at_rest():
    """Pressure on a wall, rho g H^2/2, on its lower part, and at the floor, at time 0."""
    part = {"box": {"min": [0.0, 0.0], "max": [4.0, 2.0]}}
    case = scene(
        2,
        box([0.0, 0.0], [4.0, 6.0], material="water"),
        cells=[4, 8],
        gravity=[0.0, -2.0],
        boundaries=WALLS,
        materials={"water": WATER},
        start={"stress": {"k0": 1.0}},
        gauges={
            "wall": {"wall": "x-max"},
            "low": {"wall": "x-max", "within": part},
            "floor": {"wall": "y-min"},
            "level": {"level": [2.0], "bodies": ["body"]},
        },
        step=0.001,
    )
    sim = start(case)
    line = sim.diagnostics()
    assert line["gauge.wall.force"] == pytest.approx(2.0 * 6.0**2 / 2, rel=0.01)
    assert line["gauge.low.force"] == pytest.approx(2.0 * (6.0**2 - 4.0**2) / 2, rel=0.01)
    assert line["gauge.low.pressure"] == pytest.approx(2.0 * 5.0, rel=0.01)
    assert line["gauge.floor.pressure"] == pytest.approx(2.0 * 6.0, rel=0.01)
    assert line["gauge.level.height"] == pytest.approx(6.0, rel=1e-12)
    # A drop torn apart is water and void: it fills no more than a per cent above its own volume.
    rows = sim.live()
    torn = rows[np.argmax(sim.particles.x[rows, 1] + sim.particles.x[rows, 0])]
    top = sim.particles.x[torn, 1]
    sim.particles.V[torn] *= 30.0
    sim.particles.x[torn, 0] = 2.0
    line, most = sim.diagnostics(), 1.01 * sim.particles.V0[torn]
    assert line["gauge.level.height"] == pytest.approx(6.0 + most, rel=1e-9)
    assert line["gauge.level.top"] == pytest.approx(top + 0.5 * np.sqrt(most), rel=1e-9)


def test_a_jet_carries_its_momentum():
    """Density times area times v and v^2 through a plane, also an oblique one; and means of it."""
    gauges = {
        "gate": {"flux": half([4.3, 0.0], [1.0, 0.0]), "mean": 0.5},
        "slanted": {"flux": half([5.0, 4.0], [1.0, -0.5])},
        "net": {"flux": {"box": {"min": [3.0, 0.0], "max": [6.0, 8.0]}}},
        "part": {"flux": half([4.3, 0.0], [1.0, 0.0]),
                 "within": {"box": {"min": [0.0, 0.0], "max": [8.0, 4.0]}}},
        "cut": {"cut": half([4.3, 0.0], [1.0, 0.0])},
    }  # fmt: skip
    jet = box([1.0, 3.0], [7.0, 5.0], [1.5, 0.0])
    sim = start(scene(2, jet, cells=[16, 8], end=1.0, step=0.05, gauges=gauges))
    for _ in range(11):
        line = sim.diagnostics()
        assert line["gauge.gate.mass-flux"] == pytest.approx(2.0 * 1.5, rel=1e-9)
        assert line["gauge.gate.momentum-flux-x"] == pytest.approx(2.0 * 1.5**2, rel=1e-9)
        assert line["gauge.gate.momentum-flux-y"] == pytest.approx(0.0, abs=1e-12)
        assert line["gauge.part.mass-flux"] == pytest.approx(1.5, rel=1e-9)
        assert line["gauge.slanted.mass-flux"] == pytest.approx(2.0 * 1.5, rel=0.02)
        assert line["gauge.cut.force-x"] == pytest.approx(0.0, abs=1e-9)
        assert line["gauge.gate.mean.mass-flux"] == pytest.approx(3.0, rel=1e-9)
        sim.advance()
    first = start(scene(2, jet, cells=[16, 8], gauges=gauges)).diagnostics()
    assert first["gauge.net.mass-flux"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("at", [7.6, 8.0])
def test_a_jet_that_leaves_the_domain_carries_its_momentum(at):
    """Within a cell of an open end the mean is over what is inside."""
    gauges = {
        "exit": {"flux": half([at, 0.0], [1.0, 0.0])},
        "entry": {"flux": half([0.0, 0.0], [-1.0, 0.0])},
    }
    jet = box([0.0, 3.0], [8.0, 5.0], [1.5, 0.0])
    line = start(scene(2, jet, cells=[8, 8], gauges=gauges)).diagnostics()
    assert line["gauge.exit.mass-flux"] == pytest.approx(2.0 * 1.5, rel=0.03)
    assert line["gauge.entry.mass-flux"] == pytest.approx(-2.0 * 1.5, rel=1e-9)


def test_a_flux_is_of_what_moves():
    """Between held walls a cell apart nothing moves, though particles keep their velocity.

    And of a jet that speeds up the lines add up to the mass that has passed, however few they are.
    """
    gauges = {"gate": {"flux": half([4.3, 0.0], [1.0, 0.0]), "mean": 1.0}}
    held = {"y-min": "fixed", "y-max": "fixed"}
    stuck = box([1.0, 0.0], [7.0, 1.0], [1.5, 0.0])
    sim = start(scene(2, stuck, cells=[16, 1], end=1.0, step=0.05, gauges=gauges, boundaries=held))
    assert sim.diagnostics()["gauge.gate.mass-flux"] == pytest.approx(1.5, rel=1e-9)
    while not sim.finished:
        sim.advance()
    assert (sim.particles.v[sim.live(), 0] == 1.5).all()
    assert sim.diagnostics()["gauge.gate.mass-flux"] == pytest.approx(0.0, abs=1e-12)

    jet = box([1.0, 3.0], [6.0, 5.0], [1.5, 0.0])
    case = scene(2, jet, cells=[16, 8], end=2.0, step=0.05, gauges=gauges, gravity=[2.0, 0.0])
    sim, passed, before = start(case), 0.0, 0.0
    sim.diagnostics()
    began = inside(sim.particles.x[sim.live(), 0]) @ sim.particles.m[sim.live()]
    for steps in (6, 14, 20):
        for _ in range(steps):
            sim.advance()
        line = sim.diagnostics()
        passed, before = passed + line["gauge.gate.mass-flux"] * (sim.time - before), sim.time
        left = inside(sim.particles.x[sim.live(), 0]) @ sim.particles.m[sim.live()]
        assert passed == pytest.approx(began - left, rel=1e-9)
    assert line["gauge.gate.mean.mass-flux"] == pytest.approx(line["gauge.gate.mass-flux"])


def inside(x):
    """Integral of a tent of a cell about 4.3 from x on."""
    away = np.clip(x - 4.3, -1.0, 1.0)
    return 0.5 - away + 0.5 * away * np.abs(away)


@pytest.mark.parametrize(
    ("column", "kind"),
    [
        ("gauge.waist.force-y", "force"),
        ("gauge.a.mean.moment-z", "energy"),
        ("gauge.a.mass-flux", "mass/time"),
        ("gauge.a.mean.momentum-flux-x", "force"),
        ("gauge.a.pressure", "stress"),
        ("gauge.a.height", "length"),
    ],
)
def test_columns_have_units(column, kind):
    assert kind_of_column(column) == kind
