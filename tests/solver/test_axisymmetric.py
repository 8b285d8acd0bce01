"""Axisymmetric scenes: exact volumes, pressures in balance, a tube, refused combinations."""

import numpy as np
import pytest
from ring_section import SOLID, box, case

import pgimp
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

pytestmark = pytest.mark.slow(60)


@pytest.mark.parametrize(
    ("region", "volume", "error"),
    [
        (box([0, 0.1], [1.3, 1.7]), np.pi * 1.3**2 * 1.6, 1e-13),
        (box([0.6, 0], [1.1, 2]), np.pi * (1.1**2 - 0.6**2) * 2, 1e-13),
        # Sections measured as in plane strain, to 2e-6 at eight boxes a radius, and centroids.
        ({"ball": {"center": [0, 1], "radius": 0.9}}, 4 / 3 * np.pi * 0.9**3, 1e-5),
        ({"ball": {"center": [1.5, 1], "radius": 0.7}}, 2 * np.pi**2 * 1.5 * 0.7**2, 1e-5),
    ],
)
def test_masses_are_of_the_whole_body(region, volume, error):
    sim = pgimp.Simulation(case(region))
    assert sim.diagnostics()["mass"] == pytest.approx(2.0 * volume, rel=error)


@pytest.mark.parametrize(
    ("shape", "configuration"),
    [
        ("gimp", "current"),
        pytest.param("finite-gimp", "current", marks=pytest.mark.wide),
        pytest.param("cpdi", "current", marks=pytest.mark.wide),
        ("cpdi", "initial"),
    ],
)
@pytest.mark.parametrize("inner", [0.0, 0.6])
def test_pressure_all_round_holds_a_uniform_stress(shape, configuration, inner):
    """Tractions balance it at every vertex, where surfaces cut particles, too."""
    sides = ["x-max", "y-max", *(["x-min"] if inner else [])]
    sim = pgimp.Simulation(
        case(
            box([inner, 0.0], [1.5, 1.2]),
            material=SOLID | {"model": "hooke"},
            shape=shape,
            configuration=configuration,
            boundaries={"y-min": "slip"},
            tractions={face: {"body": "b", "face": face, "pressure": 1.0} for face in sides},
        )
    )
    sim.core.particles.sigma[:, :3] = -1.0
    sim.diagnostics()
    sim.step(100)
    line, ring = sim.diagnostics(), np.pi * (1.5**2 - inner**2)
    assert line["traction.y-max-y"] == pytest.approx(-ring, rel=1e-12)
    assert line["traction.x-max-x"] == pytest.approx(-2.0 * np.pi * 1.5 * 1.2, rel=1e-12)
    assert np.abs(sim.particles["velocity"]).max() < 1e-12
    assert np.abs(sim.particles["stress"][:, :3] + 1.0).max() < 1e-12


def lame(h, configuration, inner=0.5, outer=1.0, p=1.0):
    """Greatest error of the displacement of a tube under inner pressure, over the greatest."""
    young, poisson = 1e4, 0.3
    end = 12.0  # fifty periods
    sim = pgimp.Simulation(
        case(
            box([inner, 0.0], [outer, 2 * h]),
            material={"model": "neo-hookean", "young": young, "poisson": poisson, "density": 20.0},
            size=(1.25, 2 * h),
            h=h,
            end=end,
            configuration=configuration,
            boundaries={"y-min": "slip", "y-max": "slip"},
            tractions={
                "bore": {"body": "b", "face": "x-min", "pressure": {"table": [[0, 0], [end, p]]}}
            },
            output={"fields": ["displacement", "stress"]},
        )
    )
    sim.advance()
    r = sim.particles["position"][:, 0]
    A = p * inner**2 / (outer**2 - inner**2)
    u = (1 + poisson) / young * A * ((1 - 2 * poisson) * r + outer**2 / r)
    hoop = A * (1 + outer**2 / r**2)
    return (
        np.abs(sim.particles["displacement"][:, 0] - u).max() / u.max(),
        np.sqrt(((sim.particles["stress"][:, 2] - hoop) ** 2).mean()) / hoop.max(),
    )


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_tube_under_pressure(configuration):
    """Lame's solution; strains of 2e-4, and inertia of a slow load of 1e-3, are not in it."""
    coarse, fine = lame(0.125, configuration), lame(0.0625, configuration)
    assert fine[0] < 0.006
    assert fine[1] < 0.02  # of particles at the surfaces
    assert fine[0] < coarse[0]
    assert fine[1] < 0.7 * coarse[1]


def test_totals_across_the_axis_vanish():
    """Of rings that move outwards, momentum across the axis is none, energy is all round."""
    sim = pgimp.Simulation(
        case(
            box([0.5, 0.5], [1.0, 1.0]),
            tractions={"in": {"body": "b", "face": "x-min", "pressure": 10.0}},
        )
    )
    sim.step(20)
    line = sim.diagnostics()
    assert (line["momentum-x"], line["angular-momentum-z"]) == (0.0, 0.0)
    assert line["kinetic-energy"] > 0.0
    total = line["kinetic-energy"] + line["strain-energy"] + line["dissipated-energy"]
    assert total == pytest.approx(line["external-work"], rel=1e-12)


#: A rigid disk that moves freely, of density 4.
DISK = {"rigid": {"density": 4.0}, "region": box([0.0, 1.2], [1.0, 1.6])}


def simulation(case):
    """A simulation on one rank."""
    return Simulation(case, Serial())


@pytest.mark.parametrize(
    ("region", "mass", "middle", "error"),
    [
        (box([-1.0, 1.0], [1.0, 1.5]), np.pi * 0.5, 1.25, 1e-13),
        (box([0.5, 1.0], [1.0, 1.5]), np.pi * 0.75 * 0.5, 1.25, 1e-13),
        ({"ball": {"centre": [0.0, 1.4], "radius": 0.5}}, 4 / 3 * np.pi * 0.125, 1.4, 1e-6),
    ],
)
def test_a_free_rigid_body_falls_along_the_axis(region, mass, middle, error):
    """Mass and centre are of the whole body; it falls exactly, and does not turn or go aside."""
    sim = simulation(pgimp.load(
        case(
            box([0.0, 0.0], [1.0, 0.5]), end=0.05, gravity=[0.0, -2.0],
            **{"contact": [{"bodies": "all"}]},
        ),
        {"bodies.disk": {"rigid": {"density": 4.0}, "region": region}},
    ))  # fmt: skip
    (body,) = sim.scene.interaction.rigid_bodies.free.values()
    assert body.bulk.mass == pytest.approx(4.0 * mass, rel=error)
    assert body.bulk.centre == (0.0, pytest.approx(middle, abs=10.0 * error), 0.0)
    while not sim.finished:
        sim.advance()
    line = sim.diagnostics()
    assert line["rigid.disk.velocity-y"] == pytest.approx(-0.1, rel=1e-12)
    assert line["rigid.disk.momentum-y"] == pytest.approx(-0.4 * mass, rel=error + 1e-12)
    assert line["rigid.disk.displacement-x"] == line["rigid.disk.angle-z"] == 0.0


@pytest.mark.parametrize(("left", "warned"), [(0.0, True), (-0.05, True), (-1.0, False)])
def test_a_section_that_ends_on_the_axis_is_warned_of(left, warned):
    plate = {"rigid": {}, "region": box([left, 1.0], [1.0, 1.5])}
    sim = simulation(pgimp.load(
        case(box([0.0, 0.0], [1.0, 0.5]), end=0.05, **{"contact": [{"bodies": "all"}]}),
        {"bodies.plate": plate},
    ))  # fmt: skip
    said = [text for text in sim.warnings if "its section ends on the axis" in text]
    assert len(said) == warned
    assert all("bodies.plate.region" in text and "x = -1 to 1" in text for text in said)


@pytest.mark.wide
def test_a_rigid_disk_is_slowed_down_by_the_wave_that_it_sends():
    """A column between smooth walls: v = v0 exp(-rho c A t/m) all round, until the wave is back."""
    solid = {"model": "hooke", "young": 1000.0, "poisson": 0.0, "density": 2.0}
    sim = simulation(pgimp.load(
        case(
            box([0.0, 0.0], [1.0, 4.0]), material=solid, size=(1.0, 5.0), h=0.125, end=0.12,
            boundaries={"x-max": "slip", "y-min": "fixed"}, contact=[{"bodies": "all"}],
        ),
        {
            "bodies.disk": {
                "rigid": {"density": 8.0}, "region": box([-1.0, 4.0], [1.0, 4.5]),
                "velocity": [0.0, -0.5],
            },
            "history.every": {"steps": 1},
        },
    ))  # fmt: skip
    (body,) = sim.scene.interaction.rigid_bodies.free.values()
    mass, c = 8.0 * np.pi * 0.5, np.sqrt(500.0)
    assert body.bulk.mass == pytest.approx(mass, rel=1e-12)
    expected, line = mass * -0.5, sim.diagnostics()
    while not sim.finished:
        before = line["time"]
        sim.advance()
        line = sim.diagnostics()
        # On the grid the wave's foot, 1e-6 of it, is at the floor already.
        expected += line["reaction.y-min-y"] * (line["time"] - before)
    exact = -0.5 * np.exp(-2.0 * c * np.pi * sim.time / mass)
    assert line["rigid.disk.velocity-y"] == pytest.approx(exact, rel=6e-3)
    assert abs(exact) < 0.3 * 0.5  # it has been slowed down
    total = line["momentum-y"] + line["rigid.disk.momentum-y"]
    assert total == pytest.approx(expected, rel=1e-11)
    assert abs(line["rigid.disk.force-x"]) < 1e-9 * abs(line["rigid.disk.force-y"])


@pytest.mark.wide
def test_a_rigid_disk_at_rest_weighs_on_a_pad():
    """The force between them is its weight, all round, when it has settled."""
    sim = simulation(pgimp.load(
        case(
            box([0.0, 0.0], [1.5, 1.0]), material=SOLID | {"young": 1.0e4}, h=0.125, end=4.0,
            boundaries={"y-min": "fixed"}, contact=[{"bodies": "all", "friction": 0.3}],
            gravity=[0.0, {"table": [[0.0, 0.0], [2.0, -3.0]]}], size=(2.0, 2.0),
        ),
        {
            "bodies.disk": DISK | {"region": box([0.0, 1.0], [1.0, 1.4])},
            "method.pic-damping": 10.0,
        },
    ))  # fmt: skip
    while not sim.finished:
        if sim.time < 3.5:
            sim.diagnostics()
        sim.advance()
    line, weight = sim.diagnostics(), 3.0 * 4.0 * np.pi * 0.4
    assert line["rigid.disk.force-y"] == pytest.approx(weight, rel=0.01)
    assert abs(line["rigid.disk.velocity-y"]) < 1e-3


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"dimensions": 3}, "geometry: axisymmetric is for 2 dimensions"),
        ({"grid.origin": [-1.0, 0.0]}, "grid.origin.0: x is the radius"),
        ({"method.shape": "bspline-quadratic"}, "method.shape: bspline-quadratic has no axisymm"),
        ({"grid.origin": [0.1, 0.0]}, "grid.origin.0: begins within a cell from the axis"),
        ({"boundaries": {"x-min": "fixed"}}, "boundaries.x-min: is the axis"),
        ({"gravity": [1.0, 0.0]}, "gravity: acts along the axis"),
        ({"bodies.b.velocity": [1.0, 0.0]}, "bodies.b.velocity: is along the axis"),
        (
            {"bodies.disk": DISK | {"velocity": [1.0, 0.0]}},
            "bodies.disk.velocity: is along the axis",
        ),
        (
            {"bodies.disk": DISK | {"velocity": {"rotation": {"about": [0, 0], "rate": 1.0}}}},
            "bodies.disk.velocity: is along the axis",
        ),
        (
            {"bodies.disk": DISK | {"rigid": {"density": 4.0, "force": [1.0, 0.0]}}},
            "bodies.disk.rigid.force: acts along the axis",
        ),
    ],
)
def test_what_rings_cannot_be_is_refused(change, told):
    with pytest.raises(pgimp.CaseError) as error:
        pgimp.load(case(box([0, 0], [1, 1])), change)
    assert told in str(error.value).replace("\n", " ")
