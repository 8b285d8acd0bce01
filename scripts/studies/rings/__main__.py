"""Measures axisymmetric scenes against exact results and 3D; see scripts/rings."""

from statistics import median
from time import process_time

import numpy as np
from studies.harness import CASES, origin

import pgimp

#: Of the tube in cases/tube.yaml: pressure, Young's modulus, Poisson's ratio.
PRESSURE, YOUNG, POISSON = 6.283185307e7, 1.661538461538e11, 0.03846153846154
#: Rounds and steps of the comparison by turns, after some steps that do not count.
ROUNDS, STEPS = 15, 20


def tube():
    """Displacement at the bore in mm, and the mean error of the hoop's stress over the greatest."""
    sim = pgimp.Simulation(CASES / "tube.yaml")
    sim.advance()
    r, u = sim.particles["position"][:, 0], sim.particles["displacement"][:, 0]
    # In a tube without body forces the displacement is c r + d/r.
    start = r - u
    c, d = np.linalg.lstsq(np.stack([start, 1.0 / start], axis=1), u, rcond=None)[0]
    hoop = PRESSURE / 3.0 * (1.0 + 1.0 / r**2)
    error = np.abs(sim.particles["stress"][:, 2] - hoop).mean() / hoop.max()
    return 1e3 * (0.5 * c + 2.0 * d), error


def bar(space, volumetric):
    """Taylor's bar: length in mm, greatest plastic strain, plastic work over energy, seconds."""
    changes = {"method.volumetric": volumetric}
    if space:
        h = 4.0e-4
        changes |= {
            "grid.cell": [h, h, h], "grid.size": [84 * h, 24 * h, 24 * h],
            "method.shape": "finite-gimp", "method.affine": False,
        }  # fmt: skip
    name = "taylor-bar" if space else "taylor-axisymmetric"
    sim = pgimp.Simulation(CASES / f"{name}.yaml", overrides=changes)
    energy = sim.diagnostics()["kinetic-energy"]
    sim.step()
    began = process_time()
    sim.advance()
    seconds = process_time() - began
    along = sim.particles["position"][:, 0 if space else 1] + sim.particles["radius"]
    work = sim.diagnostics()["plastic-work"] / energy
    return 1e3 * along.max(), sim.particles["plastic-strain"].max(), work, seconds


def block(geometry, shape, volumetric):
    """A block of 25,600 particles that moves along y, under way."""
    sim = pgimp.Simulation({
        "format": 1, "dimensions": 2, "geometry": geometry,
        "grid": {"size": [90.0, 110.0], "cell": [1.0, 1.0]},
        "method": {"shape": shape, "particles_per_cell": [2, 2], "volumetric": volumetric},
        "time": {"end": 1.0e4, "step": {"courant": 0.3}},
        "materials": {
            "m": {"model": "neo-hookean", "young": 1.0e3, "poisson": 0.3, "density": 1.0},
        },
        "bodies": {"b": {
            "material": "m", "velocity": [0.0, 0.1],
            "region": {"box": {"min": [0.0, 3.0], "max": [80.0, 83.0]}},
        }},
        "boundaries": {"x-min": "slip"},
    })  # fmt: skip
    sim.step(STEPS)
    return sim


def cost(shape, volumetric):
    """Time of a step over that of plane strain, by turns."""
    sims = [block(geometry, shape, volumetric) for geometry in ("plane-strain", "axisymmetric")]
    ratios = []
    for turn in range(ROUNDS):
        spent = [0.0, 0.0]
        for which in (0, 1) if turn % 2 else (1, 0):
            began = process_time()
            sims[which].step(STEPS)
            spent[which] = process_time() - began
        ratios.append(spent[1] / spent[0])
    return median(ratios)


def main():
    """Print all figures."""
    print(f"Measured on one core of {origin()}.\n")
    bore, error = tube()
    print(f"tube: displacement at the bore {bore:.4f} mm, mean error of the hoop {error:.2%}")
    for volumetric in ("mean", "pointwise"):
        for space in (False, True):
            length, strain, work, seconds = bar(space, volumetric)
            kind = "a quarter in 3D" if space else "rings"
            print(
                f"Taylor's bar, {volumetric}, {kind}: {length:.3f} mm, plastic strain "
                f"{strain:.2f}, plastic work {work:.3f}, {seconds:.1f} s"
            )
    for shape, volumetric in (
        ("gimp", "pointwise"),
        ("finite-gimp", "pointwise"),
        ("gimp", "mean"),
    ):
        print(f"{shape}, {volumetric}: {cost(shape, volumetric):.3f} of plane strain")
