"""What ``pgimp check`` says of a case."""

from pgimp.case.reader import read_case
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.checks.facts import examine
from pgimp.scene.checks.locking import locking
from pgimp.scene.checks.sanity import body_warnings
from pgimp.scene.scene import Scene


def findings(case):
    scene = Scene(case)
    lattice, counts, _ = count_particles(scene, Serial())
    return examine(scene, lattice, counts)


def facts(case):
    return findings(case).bodies


def said(case):
    of_bodies = [text for body in facts(case) for text in body_warnings(case, body, case.time.end)]
    return [*of_bodies, *locking(case)]


PLATE = """
format: 1
dimensions: 2
grid: {size: [10.0, 4.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 1.0, step: {courant: 0.3}}
materials: {m: {model: hooke, young: 1.0e+6, poisson: 0.0, density: 1000.0}}
bodies: {beam: {material: m, region: {box: {min: [0.0, 1.0], max: [8.0, 2.0]}}}}
"""


def plate(*more):
    return read_case(PLATE + "\n".join(more), "plate.yaml")


# A steel block of 0.1 m on a floor, in each of two consistent sets of units, and mixed up.
SI = {"units": "m, kg, s", "young": 2.1e11, "density": 7850.0, "side": 0.1, "gravity": 9.81}


MM = {"units": "mm, t, s", "young": 2.1e5, "density": 7.85e-9, "side": 100.0, "gravity": 9810.0}


BLOCK = """
format: 1
units: {units}
dimensions: 1
grid: {{size: [{twice}], cell: [{cell}]}}
method: {{shape: gimp, particles-per-cell: [2]}}
time: {{end: {end}, step: {{courant: 0.3}}}}
materials: {{steel: {{model: linear-1d, young: {young}, density: {density}}}}}
bodies: {{block: {{material: steel, region: {{box: {{min: [0.0], max: [{side}]}}}}}}}}
gravity: [-{gravity}]
boundaries: {{x-min: fixed}}
"""


def block(end=1.0e-3, **of):
    text = BLOCK.format(**of, end=end, twice=2.0 * of["side"], cell=0.1 * of["side"])
    return read_case(text, "block.yaml")
