"""Particles to grid, momentum update and grid to particles against plain NumPy (reference.py)."""

import copy

import numpy as np
import pytest
from kernel_driver import KINDS, SEED, Rank, entry, follows, make_frame
from tiers import wide
from transfer_setting import CELL, DT, GRAVITY, LIGHTEST, ORIGIN, close, copied, faces_of, setting

from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.particles import Particles
from pgimp.physics.boundaries import BOUNDARIES

pytestmark = pytest.mark.slow(25)

EVERY = pytest.mark.parametrize(
    ("name", "D"),
    [
        (name, D) if D == 2 or (name, D) == ("gimp", 3) else wide(name, D)
        for name in KINDS
        for D in (1, 2, 3)
    ],
)  # fmt: skip


def records_agree(rank, *expected):
    """Compare the records' parts: a scalar (or None) and two vectors."""
    G = rank.records()
    D = G.ndim - 1
    return (
        all(
            part is None or close(G[..., columns], part)
            for columns, part in zip((0, slice(1, 1 + D), slice(5, 5 + D)), expected, strict=True)
        )
        and not G[..., [*range(1 + D, 4), *range(5 + D, 8)]].any()
    )


@EVERY
def test_particles_to_grid(name, D):
    """(16), (21), (22), and what the sums conserve: (24), (25), and the moment of momentum."""
    rank, reference, p = setting(name, D)
    rank.particles_to_grid()
    reference.particles_to_grid(p)
    assert records_agree(rank, reference.m, reference.p, reference.f)

    G = rank.records().reshape(-1, 8)
    x = np.stack([c.ravel() for c in np.meshgrid(*reference.vertices, indexing="ij")], axis=1)
    momentum = G[:, 1 : 1 + D]
    assert close(G[:, 0].sum(), p.m.sum())
    assert close(momentum.sum(axis=0), (p.m[:, None] * p.v).sum(axis=0))
    assert np.abs(G[:, 5:8].sum(axis=0)).max() < 1e-13 * np.abs(G[:, 5:8]).sum()
    if D > 1:
        turn = x[:, 0] @ momentum[:, 1] - x[:, 1] @ momentum[:, 0]
        assert close(turn, p.m @ (p.x[:, 0] * p.v[:, 1] - p.x[:, 1] * p.v[:, 0]))


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("D", [2, pytest.param(3, marks=pytest.mark.wide)])
def test_particles_to_grid_between_two_sorts(name, D):
    """Particles have moved since their rows were sorted: the order within a layer is stale."""
    rank, reference, _ = setting(name, D)
    rng = np.random.default_rng(SEED)
    for layer in np.unique(rank.up_to_date().layer):
        rows = np.flatnonzero(rank.up_to_date().layer == layer)
        rank.up_to_date().x[rows, 1:] = rank.up_to_date().x[rng.permutation(rows), 1:]
    rank.particles_to_grid()
    reference.particles_to_grid(copied(rank))
    assert records_agree(rank, reference.m, reference.p, reference.f)


@EVERY
def test_momentum_update_without_walls(name, D):
    """(14) and (17); a vertex that is too light goes on as it was, and the work of gravity."""
    rank, reference, p = setting(name, D)
    rank.particles_to_grid()
    reference.particles_to_grid(p)
    mass_cutoff = 1.001 * float(np.median(reference.m[reference.m > 0]))
    rank.update_momentum(DT, GRAVITY[:D], (), mass_cutoff)
    reference.update_momentum(DT, GRAVITY, (), mass_cutoff)
    assert (reference.v == 0).any() and (reference.v != 0).any()
    assert records_agree(rank, reference.m, reference.v, reference.a)
    assert close(rank.work.sum(), reference.work)


#: Conditions by kernels of their own: faces that absorb or join have others.
CONDITIONS = [name for name, each in BOUNDARIES.items() if not each.absorbs and not each.joins]


@EVERY
@pytest.mark.parametrize("kind", CONDITIONS)
def test_every_condition_on_every_face(name, D, kind):
    """Vertices on the face and beyond, whichever face; its impulse and work."""
    rank, reference, p = setting(name, D)
    rank.particles_to_grid()
    reference.particles_to_grid(p)
    free = copy.deepcopy(reference)
    free.update_momentum(DT, GRAVITY, (), LIGHTEST)
    changed = []
    for kernel, face in faces_of(kind, D):
        rank.particles_to_grid((kernel,))
        rank.update_momentum(DT, GRAVITY[:D], (kernel,), LIGHTEST)
        reference.update_momentum(DT, GRAVITY, (face,), LIGHTEST)
        changed.append((reference.v != free.v).any())
        assert records_agree(rank, reference.m, reference.v, reference.a)
        assert close(rank.impulse.sum(axis=0)[:, :D], reference.impulse)
        assert close(rank.work.sum(), reference.work)
    assert any(changed) if kind == "unilateral" else all(changed)


@pytest.mark.parametrize(
    "name", ["gimp", *(pytest.param(n, marks=pytest.mark.wide) for n in KINDS if n != "gimp")]
)
def test_conditions_meet_at_edges_and_corners(name):
    """All kinds at once; where two faces meet each acts on what the one before left."""
    rank, reference, p = setting(name, 3)
    kinds = ("slip", "unilateral", "velocity", "fixed", "unilateral", "slip")
    chosen = [faces_of(kind, 3)[i] for i, kind in enumerate(kinds)]
    conditions = tuple(kernel for kernel, _ in chosen)
    rank.particles_to_grid(conditions)
    reference.particles_to_grid(p)
    rank.update_momentum(DT, GRAVITY, conditions, LIGHTEST)
    reference.update_momentum(DT, GRAVITY, [face for _, face in chosen], LIGHTEST)
    assert records_agree(rank, reference.m, reference.v, reference.a)
    assert close(rank.impulse.sum(axis=0), reference.impulse)
    assert close(rank.work.sum(), reference.work)


@EVERY
@pytest.mark.parametrize("tracked", [True, False], ids=["tracked", "initial"])
def test_grid_to_particles(name, D, tracked):
    """(26), (27), (29), (30), stress, volume, fastest wave, layers."""
    rank, reference, p = setting(name, D)
    rank.particles_to_grid()
    reference.particles_to_grid(p)
    rank.update_momentum(DT, GRAVITY[:D], (), LIGHTEST)
    reference.update_momentum(DT, GRAVITY, (), LIGHTEST)
    before = copied(rank)
    error, _, found, rate, clamped, _ = rank.grid_to_particles(DT, tracked)
    reference.grid_to_particles(p, rank.setting.materials, rank.setting.material_of, DT, tracked)
    assert error == 0
    after = copied(rank)
    for field in ("x", "v", "F", "sigma", "V"):
        assert close(getattr(after, field), getattr(p, field)), field
    for field in ("V0", "m", "id", "cell", "body"):
        assert (getattr(after, field) == getattr(p, field)).all(), field
    assert (after.V != before.V).any() == tracked
    assert close(rate, reference.rate)

    assert clamped == reference.clamped
    assert (clamped > 0) == (name == "fuzzy-nearest" and D > 1), "a whole cell wide along y"
    half = np.array([reference.half_widths(F)[0][0] for F in after.F])
    xi = (after.x[:, 0] - half - ORIGIN[0]) / CELL[0]
    assert (after.layer == np.floor(xi) + reference.frame.ghost).all()
    changed = after.layer != before.layer
    assert found == changed.sum() > 0
    assert (rank.population.changed[:found] == np.flatnonzero(changed)).all()


@EVERY
def test_momentum_is_kept(name, D):
    """(28): what gravity gives the vertices the particles have; none else, and first moments."""
    rank, _, before = setting(name, D)
    rank.particles_to_grid()
    rank.update_momentum(DT, GRAVITY[:D])
    assert rank.grid_to_particles(DT)[0] == 0
    after = copied(rank)
    m = before.m[:, None]
    assert close((m * (after.v - before.v)).sum(axis=0), DT * m.sum() * np.array(GRAVITY[:D]))
    assert close((m * (after.x - before.x)).sum(axis=0), DT * (m * after.v).sum(axis=0))


@pytest.mark.parametrize("D", [2, *(pytest.param(D, marks=pytest.mark.wide) for D in (1, 3))])
@pytest.mark.parametrize("name", [*KINDS, "fuzzy-constant"])
def test_uniform_stress_has_no_force_inside(name, D):
    """(33): particles that are a partition of unity, with sizes that followed a compression.

    Where the size did not follow it they are none: boxes overlap, tents add up to more than one.
    Then, and where mpm sees two particles in one cell and three in the next, they push.
    """
    shape, F = entry(name, (2,) * D), np.array([0.8, 0.9, 0.7])[:D]
    cells = (9, 8, 8)[:D]
    frame = make_frame(shape, (0.0,) * D, CELL[:D], cells)
    apart = F / 2
    along = [np.arange(1.07 + s / 2, n - 1.0, s) for s, n in zip(apart, cells, strict=True)]
    xi = np.stack([c.ravel() for c in np.meshgrid(*along, indexing="ij")], axis=1)
    p = Particles.empty(len(xi), Carried(D))
    p.x[:] = xi * frame.cell
    p.F[:] = np.diag(F).ravel()
    p.V[:] = np.prod(frame.cell) * np.prod(apart)
    p.m[:] = 1.0
    p.id[:] = np.arange(len(xi))
    p.sigma[:] = np.array([3.0, -2.0, 1.5, 0.7, -0.4, 1.1])[: p.sigma.shape[1]]
    rank = Rank(shape, frame, p)
    rank.particles_to_grid()
    force = rank.records()[..., 5 : 5 + D]
    # Vertices whose cells lie where the particles add up to one, whatever the half-width.
    inside = tuple(
        slice(frame.ghost + int(np.ceil(a[0] + 2)), frame.ghost + int(a[-1] - 2) + 1) for a in along
    )
    assert force[inside].size
    scale = 3.0 * np.prod(frame.cell) / min(frame.cell)
    assert np.abs(force).max() > 0.1 * scale
    if follows(name):
        assert np.abs(force[inside]).max() < 1e-13 * scale
    else:
        assert np.abs(force[inside]).max() > 1e-3 * scale
