"""Axisymmetric scenes: exact volumes, pressures in balance, a tube, refused combinations."""

import numpy as np
import pytest

import pgimp

pytestmark = pytest.mark.slow(60)

SOLID = {"model": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 2.0}


def case(
    region, *, material=SOLID, size=(3.0, 2.0), h=0.25, end=1.0, shape="gimp",
    configuration="current", **more,
):  # fmt: skip
    return {
        "format": 1,
        "dimensions": 2,
        "geometry": "axisymmetric",
        "grid": {"size": list(size), "cell": [h, h]},
        "method": {"shape": shape, "particles_per_cell": [2, 2]},
        "time": {"end": end, "step": {"courant": 0.3}},
        "materials": {"m": material},
        "bodies": {"b": {"material": "m", "region": region, "configuration": configuration}},
    } | more


def box(low, high):
    return {"box": {"min": list(low), "max": list(high)}}


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
    [("gimp", "current"), ("finite-gimp", "current"), ("cpdi", "current"), ("cpdi", "initial")],
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
    sim.step(100)
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
            {"bodies.b.configuration": "initial", "boundaries": {"y-min": "separating"}},
            "bodies.b.configuration: initial is known in axisymmetry without contact",
        ),
    ],
)
def test_what_rings_cannot_be_is_refused(change, told):
    with pytest.raises(pgimp.CaseError) as error:
        pgimp.load(case(box([0, 0], [1, 1])), change)
    assert told in str(error.value).replace("\n", " ")
