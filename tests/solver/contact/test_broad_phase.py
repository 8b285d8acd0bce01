"""Which particles are looked at for contact, against all pairs of them."""

import numpy as np
import pytest
from scenes import start
from tiers import wide

import pgimp
from pgimp.mpi.comm import Serial
from pgimp.solver.contact.lagrangian.bonds import separating_walls, with_walls
from pgimp.solver.contact.lagrangian.broad_phase import MARGIN, BroadPhase, reach
from pgimp.solver.time.clock import Step


def case(D):
    """Three bodies, which are sent anywhere afterwards."""
    low = [2.0 + 4.0 * n for n in range(3)]
    regions = [
        {"box": {"min": [x] + [2.0] * (D - 1), "max": [x + 2.0] + [4.0] * (D - 1)}} for x in low
    ]
    return pgimp.load({
        "format": 1,
        "dimensions": D,
        "grid": {"size": [60.0] * D, "cell": [1.0] * D},
        "method": {"shape": "gimp", "particles_per_cell": [2] * D},
        "time": {"end": 1.0, "step": 0.1},
        "materials": {"jelly": {"model": "neo-hookean", "young": 1.0, "poisson": 0.3,
                                "density": 1.0}},
        "bodies": {
            name: {"material": "jelly", "region": region, "configuration": "initial"}
            for name, region in zip("abc", regions, strict=True)
        },
        "contact": [{"bodies": "all"}],
    })  # fmt: skip


@pytest.mark.parametrize("D", [1, 2, wide(3)])
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("most", [1 << 20, 40])
def test_near_particles_are_those_within_reach_of_another_body(D, seed, most, monkeypatch):
    """All that may have a vertex in common before the next search, and none that is far from it.

    With few blocks their sides are several cells, and more is looked at.
    """
    monkeypatch.setattr("pgimp.solver.contact.lagrangian.broad_phase.BLOCKS", most)
    random = np.random.default_rng((D, seed))
    sim = start(case(D))
    p, population, scene = sim.particles, sim.rank.population, sim.scene
    rows = population.order
    middles = random.uniform(10.0, 50.0, (3, D))
    p.x[rows] = middles[p.body[rows]] + random.normal(0.0, 9.0, (len(rows), D))
    p.v[rows] = 0.0
    groups = np.arange(3)
    approach = BroadPhase(scene, Serial(), with_walls(scene), separating_walls(scene))
    approach.update(population, groups, (), Step(0, 0.0, 0.1, 0.1))
    found = np.zeros(len(rows), bool)
    found[approach.near] = True

    x, body = p.x[rows], p.body[rows]
    apart = np.abs(x[:, None] - x[None]).max(axis=2)
    partners = body[:, None] != body[None]
    nearest = np.where(partners, apart, np.inf).min(axis=1)
    far = 2.0 * reach(scene)[0] + 0.8 * MARGIN
    assert D != 2 or ((nearest < far).any() and (nearest > far + 2.0).any())
    assert found[nearest < far].all()
    if most > 40:
        assert not found[nearest > far + 2.0].any()
