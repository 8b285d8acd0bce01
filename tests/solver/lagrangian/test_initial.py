"""Bodies in the initial configuration: a step in plain NumPy, and what such a grid promises."""

import re

import numpy as np
import pytest
from lagrangian import Lagrangian
from reference_materials import STRESS, matrix, voigt
from scenes import BAR, SOFT, box, field, finish, scene, start, wall
from tiers import wide

from pgimp.errors import RunError
from pgimp.kernels.data.record import FORCE, RECORD
from pgimp.scene.scene import Scene
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.state.vertex_motion import begin_motion
from pgimp.solver.transfers import sum_particles

pytestmark = pytest.mark.slow(30)

SEED = 41
STIFF = {"model": "hooke", "young": 300.0, "poisson": 0.25, "density": 2.0}


def initial(body):
    return body | {"formulation": "total-lagrangian"}


def disturbed(case):
    """Its simulation, with particles of any deformation, stress and velocity, far from the grid."""
    sim = start(case)
    rng = np.random.default_rng(SEED)
    p, rows = sim.particles, sim.live()
    p.v[rows] = rng.normal(size=p.v[rows].shape)
    p.sigma[rows] = rng.normal(size=p.sigma[rows].shape)
    p.F[rows] += 0.25 * rng.uniform(-1.0, 1.0, p.F[rows].shape)
    p.x[rows] += rng.normal(size=p.x[rows].shape) + (
        100.0 if sim.scene.domain.bounds[0][1] > 1e9 else 0.0
    )
    if p.cell_F.shape[1]:
        p.cell_F[rows] += 0.25 * rng.uniform(-1.0, 1.0, p.cell_F[rows].shape)
        p.fbar_ratio[rows] = rng.uniform(0.9, 1.1, p.fbar_ratio[rows].shape)
        p.isolation[rows] = rng.integers(0, 2, p.isolation[rows].shape)
    begin_motion(sim.rank)
    return sim


def plane(**parts):
    """Two bodies of two models, one cut by its surface, which share the grid where they touch."""
    ball = {"ball": {"centre": [2.7, 3.1], "radius": 1.3}}
    bodies = {
        "ball": initial({"material": "soft", "region": ball}),
        "box": initial(box([4.0, 2.0], [6.0, 4.0], material="stiff")),
    }
    two = {"soft": SOFT, "stiff": STIFF}
    grid = {"cells": [8, 6], "cell": [1.0, 0.8]}
    return scene(2, bodies, materials=two, step=0.004, end=0.4, **grid, **parts)


def space(**parts):
    """A block between a slip wall, a fixed one and one that moves."""
    return scene(3, initial(box([0.0, 1.0, 0.0], [3.0, 3.0, 2.0])), cells=[4, 4, 4],
                 shape="finite-gimp", per_cell=[1, 2, 2], step=0.004, end=0.4,
                 boundaries={"x-min": "fixed", "z-min": "slip", "y-max": wall(0.3, None, -0.5)},
                 **parts)  # fmt: skip


def mean(case):
    return case | {"method": case["method"] | {"volumetric": "b-bar"}}


def line(**parts):
    return scene(1, initial(box([1.3], [5.2])), cells=[7], step=0.004, end=0.4, **parts)


def whole(case):
    """The case with whole particles, whose weights are those of boxes."""
    for body in case["bodies"].values():
        body["surface"] = "whole-particles"
    return case


CASES = {
    "gimp": whole(plane(gravity=[0.4, -0.7])),
    "mean": whole(mean(plane(gravity=[0.4, -0.7]))),
    "mean in 3D": mean(space()),
    "finite-gimp": space(gravity=[0.1, 0.2, -0.3]),
    "cpdi": whole(line(shape="cpdi", boundaries={"x-min": "slip"})),
    "fuzzy-nearest": line(shape="fuzzy-nearest", wall="ghost", per_cell=3),
    "mpm": whole(line(shape="mpm", per_cell=3)),
}


@pytest.mark.parametrize(
    "name", [wide(name) if name in ("mean in 3D", "fuzzy-nearest") else name for name in CASES]
)
def test_a_step_is_that_of_the_equations(name, monkeypatch):
    case = CASES[name]
    monkeypatch.setattr(
        Scene, "_by_cells", lambda scene: False
    )  # F is then any, not that of displacements
    sim = disturbed(case)
    scene, rows = sim.scene, sim.live()
    p = type(sim.particles)(*(column[rows].copy() for column in sim.particles))
    shape = case["method"]["shape"]
    grid = Lagrangian(shape, case["method"]["particles-per-cell"], scene.domain.frame)
    grid.particles_to_grid(p)
    faces = []
    for face in scene.domain.faces:
        kind = case["boundaries"][face.name]
        given = kind["velocity"] if isinstance(kind, dict) else None
        kind = "velocity" if given else kind
        faces.append((kind, face.axis, face.side, given, [0.0] * scene.dimension))
    grid.update_momentum(0.004, case.get("gravity", [0.0] * 3), faces, sim.rank.mass_cutoff)
    grid.grid_to_particles(p, scene.materials.parameters, scene.setting.material_of, 0.004)
    sim.diagnostics()  # what reactions count from
    sim.advance()
    # Rounding of sums of up to a hundred terms of size 1, of stresses of size 1e3.
    for column in ("x", "v", "F", "V", "sigma", "L", "cell_F", "fbar_ratio", "isolation"):
        mine, theirs = getattr(sim.particles, column)[rows], getattr(p, column)
        np.testing.assert_allclose(mine, theirs, rtol=1e-11, atol=1e-11, err_msg=column)
    reactions = sim.diagnostics()
    for face, impulse in zip(scene.domain.faces, grid.impulse, strict=True):
        found = [reactions[f"reaction.{face.name}-{a}"] for a in "xyz"[: scene.dimension]]
        np.testing.assert_allclose(found, impulse / 0.004, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("D", [2, 3])
def test_forces_with_mean_dilatation_have_a_potential(D):
    """-f is the slope of the strain energy over the vertices' displacements, of any of them.

    Of whole particles; `test_exact_mean_dilatation` has those that a surface cuts.
    """
    bodies = {
        "body": initial(box([1.2, 0.8, 1.0][:D], [3.1, 3.0, 2.4][:D])),
        "crumb": initial(box([4.25] * D, [4.75] * D)),
    }
    shape = {2: "gimp", 3: "finite-gimp"}[D]  # as in tests before, which saves compiling
    case = whole(mean(scene(D, bodies, cells=[5] * D, shape=shape)))
    sim = start(case)
    sim.advance()  # so that it is known who is alone
    p, rows, frame = sim.particles, sim.live(), sim.scene.domain.frame
    assert 0 < p.isolation[rows].sum() < len(rows)
    grid = Lagrangian(shape, [2] * D, frame)
    slopes = [(grid.weights_of(p, k)[1], grid.dilatations_of(p, k)) for k in rows]
    (soft,) = sim.scene.materials.parameters
    rng = np.random.default_rng(SEED)

    def deformed(u):
        """Energy of the displacements u of the vertices; the particles are deformed by them."""
        total = 0.0
        for k, each in zip(rows, slopes, strict=True):
            F, G = (
                np.eye(D) + np.tensordot(np.moveaxis(u, -1, 0), slope, D) for slope in each
            )  # fmt: skip
            ratio = (np.linalg.det(G) / np.linalg.det(F)) ** (1.0 / D)
            p.cell_F[k], p.fbar_ratio[k] = G.ravel(), 1.0 if p.isolation[k, 0] else ratio
            p.F[k] = (p.fbar_ratio[k, 0] * F).ravel()
            full = matrix(p.F[k])
            J = np.linalg.det(full)
            stress = STRESS["NeoHookeanParameters"](soft, full, None, None)
            p.sigma[k] = voigt(stress, p.sigma.shape[1])
            change = 0.5 * soft.mu * (np.trace(full @ full.T) - 3.0) - soft.mu * np.log(J)
            total += p.V0[k] * (change + 0.5 * soft.lam * np.log(J) ** 2)
        return total

    u = 0.15 * rng.uniform(-1.0, 1.0, (*grid.shape, D))
    deformed(u)
    parts = groups_of(sim.rank)
    sum_particles(sim.rank, parts, sim.scene.interaction.loads.at(0.0), False)
    window, G = sim.rank.grid.window, sim.rank.grid.G.reshape(*sim.rank.grid.window.extent, RECORD)
    G[sim.rank.grid.active == 0] = 0.0
    cut = tuple(slice(a, a + n) for a, n in zip(window.lower, window.extent, strict=True))[:D]
    f = G[..., FORCE : FORCE + D].reshape(*G.shape[:D], D)
    for _ in range(5):
        way = rng.normal(size=u.shape)
        slope = (deformed(u + 1e-5 * way) - deformed(u - 1e-5 * way)) / 2e-5
        along = way[cut]
        found = -(f[tuple(map(slice, along.shape))] * along).sum()
        assert found == pytest.approx(slope, rel=1e-7)  # of the step's square, and of rounding


def test_translation_at_any_speed_is_free_and_exact():
    """A thousand wave speeds: no stress, and no shorter steps; it flies out of the domain."""
    steps = []
    for speed in (0.0, 1.0e4):
        case = plane()
        case["time"]["step"] = {"courant": 0.3}
        for body in case["bodies"].values():
            body["velocity"] = [speed, -0.3 * speed]
        sim = finish(start(case))
        steps.append(sim.step)
        strain = np.abs(field(sim, "F") - np.eye(2).ravel()).max()
        assert strain < 1e-10  # of displacements of 4000 cells, to rounding
        way = field(sim, "x") - field(sim, "origin")
        np.testing.assert_allclose(way, np.tile([0.4 * speed, -0.12 * speed], (len(way), 1)))
    assert steps[0] == steps[1]


def test_spin_and_momentum_last():
    """A square on eight cells keeps momentum and angular momentum to rounding in three turns."""
    motion = {"rotation": {"about": [2.0, 2.0], "rate": 1.0}, "translation": [0.3, 0.1]}
    body = initial(box([1.0, 1.0], [3.0, 3.0])) | {"velocity": motion}
    case = scene(2, body, cells=[16, 16], cell=0.25, end=20.0, step={"courant": 0.4})
    case["materials"]["soft"] = SOFT | {"young": 2600.0}  # edges move at a sixtieth of the waves
    sim = start(case)
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    assert last["angular-momentum-z"] == pytest.approx(first["angular-momentum-z"], rel=1e-12)
    total = [line["kinetic-energy"] + line["strain-energy"] for line in (first, last)]
    assert total[1] == pytest.approx(total[0], rel=1e-3)  # bounded, of the order of the step
    assert last["momentum-x"] == pytest.approx(first["momentum-x"], rel=1e-12)
    assert last["momentum-y"] == pytest.approx(first["momentum-y"], rel=1e-12)


def test_even_stretch_to_five_times_stays_even():
    """A bar between two grips that begins in the velocities of even stretch; F is 5 all over."""
    body = initial(box([1.0], [12.0]))
    grips = {
        side: {"body": "body", "velocity": [v], "region": {"box": {"min": [a], "max": [a + 1.0]}}}
        for side, a, v in (("low", 1.0, -2.0), ("high", 11.0, 2.0))
    }
    case = scene(1, body, cells=[13], shape="cpdi", end=9.0, constraints=grips)
    sim = start(case | {"time": {"end": 9.0, "step": {"courant": 0.3}}})
    p, rows = sim.particles, sim.live()
    p.v[rows, 0] = np.clip((p.x[rows, 0] - 6.5) / 4.5, -1.0, 1.0) * 2.0
    begin_motion(sim.rank)
    finish(sim)
    free = rows[p.constraint[rows, 0] == 0]
    assert len(free) == 18
    # Of 4,000 steps, whose rounding adds up.
    np.testing.assert_allclose(p.F[free, 0], 5.0, rtol=1e-11)
    np.testing.assert_allclose(p.sigma[free, 0], 4.0 * BAR["young"], rtol=1e-11)


def test_a_particle_inside_out_stops_the_run():
    case = line(shape="mpm", per_cell=3)
    case["bodies"]["body"]["velocity"] = [0.0]
    sim = start(case)
    p, rows = sim.particles, sim.live()
    p.v[rows, 0] = -300.0 * (p.x[rows, 0] - 3.0)
    begin_motion(sim.rank)
    with pytest.raises(RunError, match=r"particle \d+ of body 'body' is turned inside out"):
        finish(sim)


def test_passing_a_wall_that_does_not_hold_it_stops_the_run():
    case = space()
    case["bodies"]["body"]["region"] = {"box": {"min": [0.0, 1.0, 1.0], "max": [3.0, 3.0, 3.0]}}
    case["boundaries"] = {"x-min": "slip", "z-min": "fixed"}
    case["bodies"]["body"]["velocity"] = [0.0, 0.0, -9.0]
    with pytest.raises(RunError) as caught:
        finish(start(case))
    text = str(caught.value)
    assert re.search(r"particle \d+ of body 'body' left the domain through z-min", text), text
    assert "formulation: updated-lagrangian" in text
