"""Two soft blocks in a closed box: the case for tests in which any will do.

Where nothing depends on the scene, this one's kernels are compiled already.
"""

from scenes import box, scene

CASE = """\
# Two soft blocks in a closed box collide.
format: 1
title: Two soft blocks
dimensions: 2
grid: {origin: [0.0, 0.0], size: [12.0, 6.0], cell: [1.0, 1.0]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 2.0, step: 0.01}
materials:
  soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}
bodies:
  left: {material: soft, region: {box: {min: [1.0, 1.0], max: [4.0, 4.0]}}, velocity: [1.0, 0.0]}
  right: {material: soft, region: {box: {min: [6.0, 1.0], max: [9.0, 4.0]}}, velocity: [-1.0, 0.0]}
boundaries: {x-min: fixed, x-max: fixed, y-min: slip, y-max: slip}
output: {every: 0.3, at: [0.5, 1.0], fields: [velocity, stress, displacement, deformation]}
history: {every: {steps: 30}}
"""


def flying(**parts):
    """Two squares; the kernels are those of `CASE`."""
    bodies = {"a": box([1.0, 1.0], [4.0, 4.0], [1.0, 0.0]), "b": box([6.0, 1.0], [9.0, 4.0])}
    walls = {"x-min": "fixed", "x-max": "fixed", "y-min": "slip", "y-max": "slip"}
    return scene(2, bodies, cells=[12, 6], end=2.0, step=0.01, boundaries=walls, **parts)
