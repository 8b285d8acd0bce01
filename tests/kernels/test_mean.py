"""Mean dilatation by box overlap (``method.volumetric: b-bar``), cell by cell in plain NumPy."""

import numpy as np
import pytest
from kernel_driver import SEED, Rank, entry, make_frame, random_particles, random_positions
from rank_scenes import SCENES
from reference import Reference
from scenes import box, field, finish, scene, start, stir
from tiers import wide
from transfer_setting import CELL, DT, GRAVITY, LIGHTEST, PER_CELL, close, copied, setting

from pgimp.kernels.data.record import FORCE, MASS, RECORD, VELOCITY
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.transfers import sum_particles

#: Boxes that reach three and four vertices, in each number of directions where it is not the same.
KINDS = pytest.mark.parametrize(("name", "D"), [("gimp", 2), wide("finite-gimp", 3), ("cpdi", 2)])


class MeanRank(Rank):
    mean = 1.0


def pair(name, D, seed=SEED):
    """Rank, reference and copied particles, as `setting`, with one rate a cell."""
    pointwise, _, _ = setting(name, D, seed, mean=True)
    particles = copied(pointwise)
    for volume in (particles.V, particles.V0):
        volume *= 0.3  # some are alone, some are not
    rank = MeanRank(entry(name, PER_CELL[:D]), pointwise.frame, particles)
    return rank, Reference(name, PER_CELL[:D], rank.frame, mean=True), copied(rank)


def gradients(before, after, D):
    """What F has changed by, (n, D, D)."""
    old, new = (p.F.reshape(-1, D, D) for p in (before, after))
    return (new @ np.linalg.inv(old) - np.eye(D)) / DT


@KINDS
def test_a_step_is_that_of_the_cells(name, D):
    """Forces, velocities, deformation, stress and volume; boxes near faces and beyond cells."""
    rank, reference, p = pair(name, D)
    rank.particles_to_grid()
    reference.particles_to_grid(p)
    records = rank.records()
    assert close(records[..., 0], reference.m)
    assert close(records[..., 1 : 1 + D], reference.p)
    assert close(records[..., 5 : 5 + D], reference.f)
    assert not records[..., [*range(1 + D, 5), *range(5 + D, 8)]].any()
    plain = Reference(name, PER_CELL[:D], rank.frame)
    plain.particles_to_grid(p)
    assert not close(plain.f, reference.f, 0.05)
    if name == "cpdi":
        return
    rank.update_momentum(DT, GRAVITY[:D], (), LIGHTEST)
    reference.update_momentum(DT, GRAVITY, (), LIGHTEST)
    assert rank.grid_to_particles(DT)[0] == 0
    reference.grid_to_particles(p, rank.setting.materials, rank.setting.material_of, DT, True)
    after = copied(rank)
    for each in ("x", "v", "F", "sigma", "V", "isolation"):
        assert close(getattr(after, each), getattr(p, each)), each
    assert (after.isolation == 0).any() and (after.isolation == 1).any()
    assert ((after.isolation > 0) & (after.isolation < 1)).any()


@pytest.mark.parametrize(("name", "D"), [("gimp", 2), ("finite-gimp", 3)])
def test_the_power_of_the_forces_is_that_of_the_stresses(name, D):
    """For any velocities; and the forces have neither a sum nor a moment."""
    rng = np.random.default_rng(SEED)
    for cells in ((5, 4, 3), (9, 2, 6)):
        shape = entry(name, (2, 1, 3)[:D])
        frame = make_frame(shape, rng.normal(size=D), CELL[:D], cells[:D])
        p = random_particles(rng, random_positions(rng, frame, 37, 0.03), mean=True)
        rank = MeanRank(shape, frame, p)
        rank.particles_to_grid()
        before, grid = copied(rank), rank.grid
        G = grid.G.reshape(*grid.window.extent, RECORD)
        G[grid.active == 0] = 0.0
        force = G[..., FORCE : FORCE + D].reshape(-1, D).copy()
        v = rng.normal(size=force.shape)
        G[..., VELOCITY : VELOCITY + D] = v.reshape(*G.shape[:-1], D)
        G[..., FORCE:] = 0.0
        rank.grid_to_particles(DT)
        L = gradients(before, copied(rank), D)
        s = before.sigma
        columns = [[0, 3], [3, 1]] if D == 2 else [[0, 3, 5], [3, 1, 4], [5, 4, 2]]
        power = (before.V[:, None, None] * s[:, columns] * L).sum()
        scale = np.abs(force * v).sum()
        assert abs((force * v).sum() + power) < 1e-12 * scale
        place = np.stack(np.indices(G.shape[:-1])[:D], axis=-1).reshape(-1, D) * frame.cell
        assert np.abs(force.sum(axis=0)).max() < 1e-13 * np.abs(force).sum()
        moment = place[:, 0] @ force[:, 1] - place[:, 1] @ force[:, 0]
        assert abs(moment) < 1e-12 * np.abs(place * force).sum()


@pytest.mark.parametrize(("name", "D"), [("gimp", 2), ("finite-gimp", 3)])
def test_affine_fields_are_seen_as_they_are(name, D):
    """All cells have the same rate then: that of the field, in which pointwise particles agree."""
    rng = np.random.default_rng(SEED)
    found = []
    for kind in (Rank, MeanRank):
        pointwise, _, _ = setting(name, D, mean=True)
        rank = kind(entry(name, PER_CELL[:D]), pointwise.frame, copied(pointwise))
        rank.particles_to_grid()
        before, grid = copied(rank), rank.grid
        G = grid.G.reshape(*grid.window.extent, RECORD)
        place = np.stack(np.indices(G.shape[:-1])[:D], axis=-1) * CELL[:D]
        rng = np.random.default_rng(SEED)
        gradient = rng.normal(size=(D, D))
        G[..., MASS], G[..., VELOCITY:] = 1.0, 0.0
        G[..., VELOCITY : VELOCITY + D] = place @ gradient.T
        rank.grid_to_particles(DT)
        after = copied(rank)
        np.testing.assert_allclose(
            gradients(before, after, D), np.broadcast_to(gradient, (len(after.m), D, D)), atol=1e-11
        )
        found.append(after)
    for each in ("x", "v", "F", "sigma", "V"):
        assert close(*(getattr(p, each) for p in found), 1e-13), each


def test_viscous_pressure_acts_through_the_cells():
    """What q changes of the forces: V_p q_p dD_p/dv_v, in a scene with nearly all that there is."""
    sim = start(SCENES["meeting"])
    p, rows, grid = sim.particles, sim.live(), sim.rank.grid
    rng = np.random.default_rng(SEED)
    forces = []
    for q in (np.zeros(len(rows)), rng.uniform(0.0, 9.0, len(rows))):
        p.q[rows, 0] = q
        p.isolation[rows] = 0.0
        parts = groups_of(sim.rank)
        sum_particles(sim.rank, parts, sim.scene.interaction.loads.at(0.0), False)
        G = grid.G.reshape(*grid.window.extent, RECORD).copy()
        G[grid.active == 0] = 0.0
        forces.append(G[..., FORCE : FORCE + 2].sum(axis=2))
    reference = Reference("finite-gimp", (2, 2), sim.scene.domain.frame, mean=True)
    expected = np.zeros((*reference.shape, 2))
    for row, pressure in zip(rows, q, strict=True):
        expected += p.V[row] * pressure * reference.dilatation_of(p.x[row], p.F[row])
    low, extent = grid.window.lower, grid.window.extent
    window = expected[low[0] : low[0] + extent[0], low[1] : low[1] + extent[1]]
    assert np.abs(window).sum() == pytest.approx(np.abs(expected).sum())
    assert close((forces[1] - forces[0])[: len(window)], window)  # none beyond the grid


def test_in_1d_it_is_the_same_to_the_bit():
    bar = box([1.3], [5.1], [0.7])
    runs = []
    for volumetric in ("pointwise", "mean"):
        case = scene(1, bar, boundaries={"x-max": "slip"})
        case["method"]["volumetric"] = volumetric
        sim = start(case)
        stir(sim, 0.5)
        runs.append([field(finish(sim), name).tobytes() for name in ("x", "v", "F", "sigma")])
    assert runs[0] == runs[1]
