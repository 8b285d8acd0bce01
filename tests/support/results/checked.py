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
method: {shape: gimp, particles_per_cell: [2, 2]}
time: {end: 1.0, step: {courant: 0.3}}
materials: {m: {model: hooke, young: 1.0e+6, poisson: 0.0, density: 1000.0}}
bodies: {beam: {material: m, region: {box: {min: [0.0, 1.0], max: [8.0, 2.0]}}}}
"""


def plate(*more):
    return read_case(PLATE + "\n".join(more), "plate.yaml")
