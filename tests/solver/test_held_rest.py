"""Particles that a face holds do not keep the velocity with which they came."""

import numpy as np
import pytest
from scenes import box, field, finish, scene, start, wall

from pgimp.kernels.grid.resting import STOPS

pytestmark = pytest.mark.slow(30)

#: Soil so soft that it has no stress to speak of.
DUST = {
    "model": "drucker-prager", "young": 1e-6, "poisson": 0.0, "density": 1.0, "cohesion": 0.0,
    "friction-angle": 30.0,
}  # fmt: skip


def thrown(dimension, face="fixed", velocity=None, configuration="current", **parts):
    """One layer of particles, a tenth of a cell above a face, that fly along it.

    Their velocity is all across what the grid can take: with point-like support a tenth of it is
    on the free vertices above, the rest on those that the face holds.
    """
    up = dimension - 1
    v = [1.0] + [0.0] * up if velocity is None else velocity
    body = box([2.0] * up + [0.0], [4.0] * up + [0.2], v) | {"formulation": configuration}
    body["material"] = "dust"
    case = scene(dimension, body, cells=[8] * up + [4], per_cell=[2] * up + [5],
                 step=0.005, **parts)  # fmt: skip
    case["materials"] = {"dust": DUST}
    case["boundaries"] = {f"{'xyz'[up]}-min": face}
    return case


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("shape", ["mpm", "gimp", "cpdi", "bspline-quadratic"])
def test_what_is_held_comes_to_rest(dimension, shape):
    """Stress-free dust near a fixed face: only the grid, which does not move there, can stop it."""
    if dimension == 1:
        case = thrown(1, shape=shape, end=1.0)
        case["bodies"]["body"]["velocity"] = [-1.0]
    else:
        case = thrown(dimension, shape=shape, end=1.0)
    sim = finish(start(case))
    # By itself 1 falls to 1/(1 + STOPS (1 - 2 z/h) t) = 0.11, z being a tenth of a cell; that the
    # particle moves, by a tenth of its velocity, takes longer. Before this it lasted for ever.
    assert np.abs(field(sim, "v")).max() < 0.2


def test_the_difference_falls_as_the_way_by_it():
    """Points on the face itself, of which it holds everything: dv/dt = -STOPS v^2/h."""
    case = thrown(2, shape="mpm", end=1.0)
    case["bodies"]["body"]["region"]["box"]["max"][1] = 1e-6
    case["method"]["particles-per-cell"] = [2, 1000000]
    sim = start(case)
    v, time = [], []
    while not sim.finished:
        sim.advance()
        v.append(field(sim, "v")[:, 0].mean())
        time.append(sim.time)
    # Steps of 0.005 at a rate of up to 10: an error of first order.
    np.testing.assert_allclose(v, 1.0 / (1.0 + STOPS * np.array(time)), rtol=0.03)


@pytest.mark.parametrize("transfer", [{}, {"affine": True}, {"relaxation": 2.0}])
@pytest.mark.parametrize("face", ["fixed", wall(0.3, 0.0)])
def test_the_face_takes_momentum_and_energy(face, transfer):
    """Books: momentum by its reaction, energy by its work and by what it takes."""
    case = thrown(2, face, velocity=[1.0, 0.2], end=0.5)
    case["method"] |= transfer
    sim = start(case)
    line, first = sim.diagnostics(), sim.diagnostics()
    while not sim.finished:
        sim.advance()
        last, line = line, sim.diagnostics()
        for axis in "xy":
            gained = line[f"momentum-{axis}"] - last[f"momentum-{axis}"]
            # Forces on vertices of less than 1e-12 of a particle are lost: 1e-6, the root.
            assert gained == pytest.approx(line[f"reaction.y-min-{axis}"] * sim.dt, abs=1e-8)
    took = line["wall.y-min.impact-loss"]
    assert took > 0.05 * first["kinetic-energy"]
    if not transfer:  # without affine and relaxation nothing else takes energy
        kept = line["kinetic-energy"] + line["strain-energy"] - first["kinetic-energy"]
        if face == "fixed":
            assert line["external-work"] == 0.0
        assert kept == pytest.approx(line["external-work"] - took, abs=0.02 * took)


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_face_that_moves_along_takes_nothing_of_what_moves_with_it(configuration):
    """Rest as the face sees it."""
    belt = wall(1.0, 0.0)
    line = finish(start(thrown(2, belt, configuration=configuration))).diagnostics()
    assert line["wall.y-min.impact-loss"] == pytest.approx(0.0, abs=1e-15)
    sim = start(thrown(2, "fixed", configuration=configuration))
    sim.diagnostics()  # the energy from which losses count
    line = finish(sim).diagnostics()
    # Vertices that keep their velocities lose them in the first step; particles have none to lose.
    loss = {"current": "wall.y-min.impact-loss", "initial": "dissipated-energy"}[configuration]
    assert line[loss] > 0.05


def test_waves_of_a_bar_are_not_damped():
    """A bar swings at its fixed end: what springs back loses nothing to the wall."""
    case = scene(2, box([0.0, 0.0], [8.0, 2.0]), cells=[10, 2], end=2.0, step=0.005,
                 boundaries={"x-min": "fixed"})  # fmt: skip
    sim = start(case)
    p, rows = sim.particles, sim.live()
    p.v[rows, 0] = 0.1 * np.sin(np.pi * p.x[rows, 0] / 16.0)
    assert finish(sim).diagnostics()["wall.x-min.impact-loss"] == 0.0


def test_what_is_farther_than_half_a_cell_has_the_bits_of_before():
    """A particle in the middle of the lowest cell: as much on free vertices as on held ones."""
    case = scene(2, box([2.0, 0.0], [5.0, 3.0], [0.3, 0.2]), per_cell=1, shape="mpm", end=0.02,
                 boundaries={"y-min": "fixed"})  # fmt: skip
    sim = finish(start(case))
    assert sim.diagnostics()["wall.y-min.impact-loss"] == 0.0
