"""Axisymmetry in the initial configuration: contact of rings, mean dilatation, exact solutions."""

import numpy as np
import pytest
from ring_section import box, case

import pgimp

pytestmark = pytest.mark.slow(120)

YOUNG, POISSON = 1000.0, 0.3
ELASTIC = {"model": "hooke", "young": YOUNG, "poisson": POISSON, "density": 2.0}


def ended(case, last):
    """A case at its end, and its last line, whose forces are means of the time from `last` on."""
    sim = pgimp.Simulation(case)
    while not sim.finished:
        sim.step(1)
        if sim.time < last:
            sim.diagnostics()
    return sim, sim.diagnostics()


@pytest.mark.wide
@pytest.mark.parametrize(
    ("top", "error"),
    [
        (1.0, 0.012),
        # Between vertices contact begins 5e-3 of a cell early, as in plane strain, to six digits.
        (1.06, 0.06),
    ],
)
def test_a_disk_pressed_by_a_plate_bears_the_oedometric_force(top, error):
    """In a smooth rigid ring, on a unilateral floor: M e pi R^2."""
    e = 0.01
    way = {"table": [[0.0, 0.0], [0.5, -2.0 * e * top], [1.0, 0.0]]}
    plate = {"rigid": {"velocity": [0.0, way]}, "region": box([-1.0, top], [2.0, top + 0.5])}
    sim, line = ended(
        pgimp.load(
            case(
                box([0.0, 0.0], [1.0, top]), material=ELASTIC, configuration="initial", h=0.125,
                size=(1.0, 2.0), end=2.0, contact=[{"bodies": "all"}],
                boundaries={"y-min": "unilateral", "x-max": "slip"},
            ),
            {"bodies.plate": plate, "damping": {"mass": 10.0}},
        ), 1.9,
    )  # fmt: skip
    modulus = YOUNG * (1 - POISSON) / (1 + POISSON) / (1 - 2 * POISSON)
    assert line["rigid.plate.force-y"] == pytest.approx(modulus * e * np.pi, rel=error)
    assert line["reaction.y-min-y"] == pytest.approx(line["rigid.plate.force-y"], rel=1e-4)
    assert sim.particles["stress"][:, 1].mean() == pytest.approx(-modulus * e, rel=error)


def cylinders(speed):
    """Two cylinders end on end, cut between vertices, that move towards each other."""
    ends = {"formulation": "total-lagrangian", "material": "m"}
    return pgimp.Simulation(
        pgimp.load(
            case(
                box([0.0, 0.5], [1.1, 1.1]), configuration="initial", size=(1.5, 2.5),
                contact=[{"bodies": "all", "friction": 0.3}],
            ),
            {
                "bodies.b.velocity": [0.0, speed],
                "bodies.c": ends | {
                    "region": box([0.0, 1.1], [1.1, 1.5]), "velocity": [0.0, -2.0 * speed]
                },
            },
        )
    )  # fmt: skip


@pytest.mark.wide
def test_cylinders_end_on_end_stay_at_rest():
    sim = cylinders(0.0)
    sim.step(50)
    assert np.abs(sim.particles["velocity"]).max() < 1e-13
    assert sim.diagnostics()["contact.all.normal-impulse"] < 1e-13


def test_contact_keeps_the_momentum_along_the_axis():
    """Whatever two cylinders exchange, with a shock in either; to rounding of what they have."""
    sim = cylinders(1.0)
    before, line = sim.diagnostics()["momentum-y"], {}
    for _ in range(10):
        sim.step(5)
        line = sim.diagnostics()
        assert abs(line["momentum-y"] - before) < 1e-13 * line["mass"]
    own, other = (sim.particles["body"] == number for number in (0, 1))
    v, m = sim.particles["velocity"][:, 1], sim.particles["mass"]
    assert (m * v)[own].sum() < 0.5 * m[own].sum()  # they have pushed each other
    assert (m * v)[other].sum() > -1.5 * m[other].sum()
    kept = line["kinetic-energy"] + line["strain-energy"]
    assert kept < 0.5 * (m[own].sum() + 4.0 * m[other].sum())


def on_a_core(h, inner):
    """Errors of a ring that a pressure presses on a rigid core: displacement, force on the core."""
    outer, p = inner + 0.5, 1.0
    core = {"rigid": {"velocity": [0.0, 0.0]}, "region": box([0.0, -1.0], [inner, 1.0])}
    rise = {"table": [[0.0, 0.0], [1.0, p]]}
    sim, line = ended(
        pgimp.load(
            case(
                box([inner, 0.0], [outer, 2 * h]), material=ELASTIC, configuration="initial", h=h,
                size=(outer + 0.125, 2 * h), end=2.0, contact=[{"bodies": "all"}],
                boundaries={"y-min": "slip", "y-max": "slip"},
                tractions={"out": {"body": "b", "face": "x-max", "pressure": rise}},
                output={"fields": ["displacement", "stress"]},
            ),
            {"bodies.core": core, "damping": {"mass": 10.0}},
        ), 1.9,
    )  # fmt: skip
    # Lame: radial stress A - B/r^2, with no displacement at the core.
    A = -p / (1 + (1 - 2 * POISSON) * inner**2 / outer**2)
    B = -(1 - 2 * POISSON) * A * inner**2
    r = sim.particles["position"][:, 0]
    u = (1 + POISSON) / YOUNG * ((1 - 2 * POISSON) * A * r + B / r)
    force = 2 * (1 - POISSON) * A * 2 * np.pi * inner * 2 * h
    found = sim.particles["displacement"][:, 0]
    return (
        np.abs(found - u).max() / np.abs(u).max(),
        abs(line["rigid.core.force-x"] / force - 1.0),
    )


@pytest.mark.parametrize(
    "inner", [0.5, pytest.param(0.125, marks=pytest.mark.wide)]
)  # one cell from the axis, on the coarse grid
def test_a_ring_pressed_on_a_rigid_core(inner):
    """Lame's solution, second order in the cell; strains of 1e-3 are not in it."""
    coarse, fine = on_a_core(0.125, inner), on_a_core(0.0625, inner)
    assert fine[0] < 0.007
    assert fine[0] < 0.5 * coarse[0]
    assert fine[1] < 0.008
    assert fine[1] < coarse[1]


def bore(h, volumetric):
    """Errors of a nearly incompressible tube under inner pressure: displacement, hoop stress."""
    inner, outer, p, shear, poisson = 0.5, 1.0, 1.0, 4000.0, 0.499
    young = 2 * shear * (1 + poisson)
    rise = {"table": [[0.0, 0.0], [0.5, p]]}
    sim = pgimp.Simulation(
        pgimp.load(
            case(
                box([inner, 0.0], [outer, 2 * h]), configuration="initial", size=(1.25, 2 * h), h=h,
                material={
                    "model": "neo-hookean", "young": young, "poisson": poisson, "density": 20.0
                },
                end=1.0, boundaries={"y-min": "slip", "y-max": "slip"},
                tractions={"bore": {"body": "b", "face": "x-min", "pressure": rise}},
                output={"fields": ["displacement", "stress"]},
            ),
            {"method.volumetric": volumetric, "damping": {"mass": 20.0}},
        )
    )  # fmt: skip
    sim.advance()
    r = sim.particles["position"][:, 0]
    A = p * inner**2 / (outer**2 - inner**2)
    u = (1 + poisson) / young * A * ((1 - 2 * poisson) * r + outer**2 / r)
    hoop = A * (1 + outer**2 / r**2)
    return (
        np.abs(sim.particles["displacement"][:, 0] - u).max() / u.max(),
        np.sqrt(((sim.particles["stress"][:, 2] - hoop) ** 2).mean()) / hoop.max(),
    )


@pytest.mark.wide
def test_a_nearly_incompressible_tube_locks_without_means_alone():
    """Lame's solution at a Poisson's ratio of 0.499, on four and eight cells."""
    locked, coarse, fine = bore(0.125, "pointwise"), bore(0.125, "mean"), bore(0.0625, "mean")
    assert locked[0] > 0.5
    assert locked[1] > 5.0
    assert coarse[0] < 0.008
    assert coarse[1] < 0.018
    assert fine[0] < 0.5 * coarse[0]
    assert fine[1] < 0.6 * coarse[1]


def wandering(dt):
    """Range of the energy of a cylinder on the axis that vibrates freely, over its mean."""
    push = {"table": [[0.0, 0.0], [0.05, 30.0], [0.1, 0.0]]}
    sim = pgimp.Simulation(
        pgimp.load(
            case(
                box([0.0, 0.25], [1.1, 1.5]), configuration="initial",
                material={"model": "neo-hookean", "young": 1000.0, "poisson": 0.45, "density": 2.0},
                tractions={
                    side: {"body": "b", "face": side, "pressure": push}
                    for side in ("x-max", "y-max")
                },
            ),
            {"method.volumetric": "b-bar", "time.step": dt, "time.end": 0.6},
        )
    )  # fmt: skip
    motion, strain = [], []
    while not sim.finished:
        sim.step(1)
        line = sim.diagnostics()
        if line["time"] > 0.11:
            motion.append(line["kinetic-energy"])
            strain.append(line["strain-energy"])
    K, P = np.array(motion), np.array(strain)
    energy = 0.5 * (K[:-1] + K[1:]) + P[:-1]  # velocities are those of the steps' middles
    return (energy.max() - energy.min()) / energy.mean()


@pytest.mark.wide
def test_forces_by_means_of_rings_have_the_energy_as_their_potential():
    """The energy wanders with the square of the step: a force without would leave a rest."""
    long, short = wandering(1e-3), wandering(5e-4)
    assert long < 2e-3
    assert short < 0.3 * long
