"""Materials see deformation gradients of particles alone, not of a cell's empty places."""

from math import sqrt
from typing import Literal, NamedTuple

import numpy as np
import pytest
from pydantic import Field
from scenes import box, scene, start

import pgimp
from pgimp.jit.algebra import cofactor, isotropic, left_cauchy_green
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.physics.materials import Material, Positive


class LimitedParameters(NamedTuple):
    """Shear modulus, limit of the first invariant less 3, and initial density."""

    mu: float
    most: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        b = left_cauchy_green(F)
        f = material.mu / sqrt(1.0 - (b[0] + b[1] + b[2] - 3.0) / material.most)
        return isotropic(f / J, b, -material.mu / J)

    @staticmethod
    def piola(material, F, J):
        b = left_cauchy_green(F)
        f = material.mu / sqrt(1.0 - (b[0] + b[1] + b[2] - 3.0) / material.most)
        return plus_scaled(-material.mu / J, cofactor(F), scaled(f, F))

    @staticmethod
    def energy(material, F, J, sigma):
        return 0.0

    @staticmethod
    def speed(material, F, J):
        return 2.0 * sqrt(material.mu / material.density)


@pytest.fixture
def limited():
    """A rubber whose stress is not a number where it is stretched too far."""

    @pgimp.register_material
    class Limited(Material):
        model: Literal["limited"] = Field(description="name of the model")
        mu: Positive = Field(description="shear modulus")
        most: Positive = Field(description="limit of the first invariant less 3")

        def parameters(self):
            return LimitedParameters(self.mu, self.most, self.density)

    return Limited


def test_empty_places_of_cut_cells_are_no_particles(limited):
    """They are stretched beyond the limit, which no particle reaches: a bar is thrown round."""
    bar = box([2.0, 2.5], [7.5, 5.5], {"rotation": {"about": [5.0, 4.0], "rate": 4.0}})
    case = scene(
        2, bar | {"formulation": "total-lagrangian"}, cells=[12, 10], step={"courant": 0.3},
        end=0.8,
        materials={"soft": {"model": "limited", "mu": 40.0, "most": 6.0, "density": 1.0}},
        constraints={"grip": {"body": "body", "velocity": [0.0, 0.0],
                              "region": {"box": {"min": [1.9, 0.0], "max": [3.0, 9.0]}}}},
    )  # fmt: skip
    sim, most = start(case), 0.0
    assert sim.rank.by_cells_alone() and (sim.rank.lattice_cells().cells.volumes == 0.0).any()
    while not sim.finished:
        sim.advance()
        F = sim.particles.F[sim.live()]
        most = max(most, float((F**2).sum(axis=1).max()) - 2.0)
    assert 2.0 < most < 5.0
    assert np.isfinite(sim.particles.sigma[sim.live()]).all()
