"""Measures axisymmetric scenes against exact results and 3D; see scripts/rings."""

from statistics import median
from time import process_time

import numpy as np
from studies.harness import CASES, origin

import pgimp
from pgimp.physics.materials.registry import import_file

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
    changes = {"method.volumetric": volumetric, "method.affine": False}
    if space:
        h = 4.0e-4
        changes |= {
            "grid.cell": [h, h, h], "grid.size": [84 * h, 24 * h, 24 * h],
            "method.shape": "finite-gimp",
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


def spinning_disk(cell):
    """The disk's errors: displacement, and means of the hoop's stress over cells; seconds.

    Each the root of the mean square and the greatest; of the stress over the greatest stress.
    """
    began = process_time()
    changes = {"grid.cell": [cell, cell]}
    sim = pgimp.Simulation(CASES / "own/spinning-disk.yaml", overrides=changes)
    sim.advance()
    seconds = process_time() - began
    a, b, nu = 0.25, 0.05, 0.3
    grown = sim.particles["displacement"][:, 0]
    r = sim.particles["position"][:, 0] - grown
    pull = (3.0 + nu) / 8.0 * 7850.0 * 500.0**2

    def hoop(r):
        square = (1.0 + 3.0 * nu) / (3.0 + nu) * r * r
        return pull * (a * a + b * b + (a * b / r) ** 2 - square)

    def means(values):
        return np.bincount(number, values) / np.bincount(number)

    radial = pull * (a * a + b * b - (a * b / r) ** 2 - r * r)
    number = np.unique(np.round(4.0 * r / cell).astype(int), return_inverse=True)[1]
    moved = means(grown / (r / 2.1e11 * (hoop(r) - nu * radial))) - 1.0
    number = np.floor((r - b) / cell).astype(int)
    stress = (means(sim.particles["stress"][:, 2]) - hoop(means(r))) / hoop(b)
    return *(each for off in (moved, stress)
             for each in (np.sqrt(np.mean(off**2)), np.abs(off).max())), seconds  # fmt: skip


def cone(cell):
    """The cone's factor on its way from 8 to 10 radii, and seconds."""
    began = process_time()
    sim = pgimp.Simulation(CASES / "cone.yaml", overrides={"grid.cell": [cell, cell]})
    found = []
    while not sim.finished:
        sim.step()
        if sim.steps % 5 == 0 and sim.time > 20.5:  # down by 8 radii
            found.append(sim.diagnostics()["rigid.cone.force-y"] / np.pi)
    return np.mean(found), process_time() - began


def block(geometry, shape, volumetric):
    """A block of 25,600 particles that moves along y, under way."""
    sim = pgimp.Simulation({
        "format": 1, "dimensions": 2, "geometry": geometry,
        "grid": {"size": [90.0, 110.0], "cell": [1.0, 1.0]},
        "method": {"shape": shape, "particles-per-cell": [2, 2], "volumetric": volumetric},
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
    for volumetric in ("b-bar", "pointwise"):
        for space in (False, True):
            length, strain, work, seconds = bar(space, volumetric)
            kind = "a quarter in 3D" if space else "rings"
            print(
                f"Taylor's bar, {volumetric}, {kind}: {length:.3f} mm, plastic strain "
                f"{strain:.2f}, plastic work {work:.3f}, {seconds:.1f} s"
            )
    import_file(str(CASES / "spin.py"))
    for cell in (0.005, 0.0025):
        *off, seconds = spinning_disk(cell)
        print(
            "spinning disk, cells of {} mm: displacement off by {:.3%} in the mean square, {:.3%} "
            "at most, the hoop's stress by {:.3%}, {:.3%}; {:.1f} s".format(
                1e3 * cell, *off, seconds
            )
        )
    for cell in (0.5, 0.25):
        factor, seconds = cone(cell)
        print(f"cone in clay, cells of {cell} radii: {factor:.2f}; {seconds:.0f} s")
    for shape, volumetric in (
        ("gimp", "pointwise"),
        ("finite-gimp", "pointwise"),
        ("gimp", "mean"),
    ):
        print(f"{shape}, {volumetric}: {cost(shape, volumetric):.3f} of plane strain")
