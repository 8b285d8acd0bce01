"""The gap that is left, in cells, when bodies that approach each other first feel it."""

from math import cos, radians, sin

import numpy as np
from studies.contact.motion import case_of
from studies.scenes import ball, box

import pgimp

#: Closing speed in cells a step; what a step leaves out is of this size.
SPEED = 0.002
#: Cells of the domain along each direction, by dimension.
CELLS = {2: 48, 3: 20}


def stiff(bodies, way):
    """Case of stiff bodies in cells of 1, of which `a` moves along `way`; with a contact of two."""
    solid = {"model": "neo-hookean", "young": 0.02, "poisson": 0.0, "density": 1.0}
    moving = {
        name: (region, (SPEED * way * (name == "a")).tolist()) for name, region in bodies.items()
    }
    return case_of(
        moving, [CELLS[len(way)]] * len(way), 1.0, 2000.0, solid, time={"step": 1.0},
        contact=[{"bodies": list(bodies)}] if len(bodies) > 1 else [],
    )  # fmt: skip


def _direction(dimensions, angle):
    return np.array([cos(radians(angle)), sin(radians(angle)), 0.0][:dimensions])


def turned(middle, half, angle):
    """A rectangle, or a cuboid, turned by `angle` about z."""
    c, s = cos(radians(angle)), sin(radians(angle))
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])[:, : len(middle)]
    planes = []
    for d in range(len(middle)):
        for normal in (axes[d], -axes[d]):
            point = middle + half[d] * normal
            planes.append({"half-space": {"point": point.tolist(), "normal": normal.tolist()}})
    return {"intersection": planes}


def felt(case, gap, column="contact.a+b.normal-impulse", least=0.0):
    """Gap that is left before the step in which bodies first feel each other, or a wall."""
    simulation = pgimp.Simulation(case)
    while not simulation.finished:
        simulation.step()
        if abs(simulation.diagnostics()[column]) > least:
            return gap - SPEED * (simulation.steps - 1)
    raise RuntimeError("they never met")


def flat(dimensions, angle, shift):
    """Gap of two flat faces, turned by `angle`, that meet at any place in a cell.

    Their distance at the start is no multiple of that of the particles, so that each lies elsewhere
    on the lattice.
    """
    way, gap = _direction(dimensions, angle), 1.0 + 0.5 * ((7.0 * shift) % 1.0)
    middle = np.full(dimensions, 0.5 * CELLS[dimensions]) + shift * way
    half = [3.0, 4.0, 4.0][:dimensions]
    bodies = {
        "a": turned(middle - (3.0 + 0.5 * gap) * way, half, angle),
        "b": turned(middle + (3.0 + 0.5 * gap) * way, half, angle),
    }
    return felt(stiff(bodies, way), gap)


def balls(dimensions, radius, angle, shift):
    """Gap of two disks or balls that meet head on; of large balls only the caps are there."""
    way, gap = _direction(dimensions, angle), 0.6 + 0.5 * ((7.0 * shift) % 1.0)
    middle = np.full(dimensions, 0.5 * CELLS[dimensions]) + shift

    def cap(side):
        centre = middle + side * (radius + 0.5 * gap) * way
        whole, near = ball(centre, radius), box(middle - 7.0, middle + 7.0)
        return whole if dimensions == 2 else {"intersection": [whole, near]}

    return felt(stiff({"a": cap(-1.0), "b": cap(1.0)}, way), gap)


def _rigid(case, name):
    """Case in which this body is rigid, and moves as it did."""
    body = case["bodies"][name]
    body.pop("material")
    body["rigid"] = {"velocity": body.pop("velocity")}
    return case


def hole(rigid, radius, angle, shift, clearance):
    """Gap of a disk that moves in a round hole of a thick ring; one of the two is rigid."""
    middle = 0.5 * CELLS[2] + shift * np.array([1.0, 0.37])
    disk, wide, ring = (
        ball(middle, r) for r in (radius, radius + clearance, radius + clearance + 4.0)
    )
    bodies = {"a": disk, "b": {"difference": [ring, wide]}}
    return felt(_rigid(stiff(bodies, _direction(2, angle)), rigid), clearance)


def plane(radius, angle, shift):
    """Gap of a rigid disk that comes down on a plane, turned by `angle`."""
    way, gap = _direction(2, angle), 0.6 + 0.5 * ((7.0 * shift) % 1.0)
    middle = np.full(2, 0.5 * CELLS[2]) + shift
    bodies = {
        "a": ball(middle - (radius + gap) * way, radius),
        "b": turned(middle + 3.0 * way, [3.0, 5.0], angle),
    }
    return felt(_rigid(stiff(bodies, way), "a"), gap)


def corner(angle, shift):
    """Gap of the corner of a square, turned by `angle`, that comes down on a plane."""
    way, gap, half = np.array([0.0, -1.0]), 1.0 + 0.5 * ((7.0 * shift) % 1.0), 3.0
    middle = np.array([15.0 + shift, 12.0 + shift])
    up = np.array([0.0, gap + half * (cos(radians(angle)) + sin(radians(angle)))])
    bodies = {
        "a": turned(middle + up, [half, half], angle),
        "b": box([5.0, 6.0], [25.0, middle[1]]),
    }
    return felt(stiff(bodies, way), gap)


def rows(quick):
    """Rows of the table: what meets, and the least and greatest gap over places in a cell."""
    shifts = np.random.default_rng(1).random(2 if quick else 8)
    few, radii = shifts[:4], (5.0,) if quick else (5.0, 10.0)
    found = {}
    for angle in (0.0, 20.0, 45.0):
        found[f"flat faces at {angle:.0f} degrees, 2D"] = [flat(2, angle, s) for s in shifts]
    for angle in () if quick else (0.0, 30.0):
        found[f"flat faces at {angle:.0f} degrees, 3D"] = [flat(3, angle, s) for s in few]
    for radius in radii:
        turns = [balls(2, radius, 30.0 * i, s) for i, s in enumerate(shifts)]
        found[f"disks, R = {radius:.0f} cells"] = turns
    for radius in () if quick else (5.0, 10.0):
        turns = [balls(3, radius, 15.0 * i, s) for i, s in enumerate(few)]
        found[f"balls, R = {radius:.0f} cells, 3D"] = turns
    for radius in radii:
        cells, places = f"R = {radius:.0f} cells", list(enumerate(few))
        for rigid, what in (("a", "a rigid disk in a hole"), ("b", "a disk in a rigid hole")):
            found[f"{what}, {cells}, clearance 0.1 and 0.6"] = [
                hole(rigid, radius, 30.0 * i, s, wide) for wide in (0.1, 0.6) for i, s in places
            ]
        found[f"a rigid disk on a plane, {cells}"] = [plane(radius, 30.0 * i, s) for i, s in places]
    corners = [corner(angle, s) for angle in (45.0, 20.0) for s in few]
    found["a square's corner and a plane"] = corners
    return [(what, min(gaps), max(gaps)) for what, gaps in found.items()]
