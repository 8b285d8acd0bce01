"""Sums over the particles by layer and body, and their fastest rate, against plain NumPy."""

from math import fsum

import numpy as np
import pytest
from kernel_driver import (
    MATERIAL_OF,
    MATERIALS,
    SEED,
    Rank,
    entry,
    make_frame,
    random_particles,
    random_positions,
)
from kernel_sums import rate_of, sums_of
from reference_materials import matrix, speed, tensor
from scenes import box, scene, start

from pgimp.kernels.sums.sums import ANGULAR, KINETIC, MASS, MOMENT, MOMENTUM, STRAIN


def energy(material, F, sigma):
    """Strain energy per initial volume."""
    J = np.linalg.det(F)
    if type(material).__name__ == "HookeParameters":
        bulk = material.lam + 2 * material.mu / 3
        mean = np.trace(sigma) / 3
        deviator = sigma - mean * np.eye(3)
        return J * (mean**2 / (2 * bulk) + (deviator**2).sum() / (4 * material.mu))
    shear = material.mu / 2 * (np.trace(F @ F.T) - 3 - 2 * np.log(J))
    return shear + material.lam / 2 * np.log(J) ** 2


@pytest.mark.parametrize("D", [1, 2, 3])
def test_sums_and_rate(D):
    rng = np.random.default_rng(SEED)
    cell = (0.7, 1.3, 0.9)[:D]
    shape = entry("gimp", (2,) * D)
    frame = make_frame(shape, (-1.1, 0.3, 2.0)[:D], cell, (6, 4, 3)[:D])
    rank = Rank(shape, frame, random_particles(rng, random_positions(rng, frame, 80)))
    sums = sums_of(rank, D, 2, MATERIAL_OF)

    p = rank.up_to_date()
    x, v = np.zeros((2, 80, 3))
    x[:, :D], v[:, :D] = p.x, p.v
    laws = [MATERIALS[MATERIAL_OF[body]] for body in p.body]
    F = [matrix(row) for row in p.F]
    strain = [energy(*args) for args in zip(laws, F, map(tensor, p.sigma), strict=True)]
    rows = np.zeros((80, sums.shape[2]))
    rows[:, MASS] = p.m
    rows[:, MOMENTUM : MOMENTUM + 3] = p.m[:, None] * v
    rows[:, ANGULAR : ANGULAR + 3] = p.m[:, None] * np.cross(x, v)
    rows[:, MOMENT : MOMENT + 3] = p.m[:, None] * x
    rows[:, KINETIC] = p.m * (v**2).sum(axis=1) / 2
    rows[:, STRAIN] = p.V0 * strain
    expected = np.zeros_like(sums)
    np.add.at(expected, (p.layer, p.body), rows)
    np.testing.assert_allclose(sums, expected, rtol=1e-12, atol=1e-12)

    waves = np.array([speed(law, f, D) for law, f in zip(laws, F, strict=True)])
    rate = (waves + np.linalg.norm(v, axis=1)).max() / min(cell)
    assert rate_of(rank, D, MATERIAL_OF) == pytest.approx(rate, rel=1e-13)


def test_mass_is_the_same_bits_wherever_particles_are():
    """The exact sum, rounded once, while they change layers and bodies meet."""
    bodies = {
        "left": box([1.0, 1.03], [5.3, 3.3], [3.0, 1.0]),
        "right": box([6.0, 1.0], [7.1, 2.7], [0.0, 2.0]),
    }
    sim = start(scene(2, bodies, cells=[20, 16], cell=0.5, end=0.5, step=0.005))
    rng = np.random.default_rng(SEED)
    m = sim.particles.m[sim.live()] * rng.uniform(1e-9, 1.0, sim.rank.count)
    sim.particles.m[sim.live()] = m
    body = sim.particles.body[sim.live()]
    expected = {"mass": fsum(m)}
    expected |= {f"body.{name}.mass": fsum(m[body == i]) for i, name in enumerate(bodies)}
    for _ in range(10):
        line = sim.diagnostics()
        assert {name: line[name] for name in expected} == expected
        for _ in range(10):
            sim.advance()
