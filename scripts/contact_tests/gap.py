"""The gap that is left, in cells, when bodies that approach each other first feel it."""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import Any

import numpy as np

import pgimp

SPEED = 0.002
"""Closing speed in cells a step: what a step leaves out is of this size."""

CELLS = {2: 30, 3: 20}


def _case(dimensions: int, bodies: dict[str, Any], way: np.ndarray) -> Any:
    """Case of stiff bodies in cells of 1, of which `a` moves along `way`."""
    cells = CELLS[dimensions]
    velocity = (SPEED * way[:dimensions]).tolist()
    return pgimp.load(
        {
            "format": 1,
            "dimensions": dimensions,
            "grid": {"size": [float(cells)] * dimensions, "cell": [1.0] * dimensions},
            "method": {"shape": "gimp", "particles_per_cell": [2] * dimensions},
            "time": {"end": 2000.0, "step": 1.0},
            "materials": {
                "solid": {"model": "neo-hookean", "young": 0.02, "poisson": 0.0, "density": 1.0}
            },
            "bodies": {
                "a": {"material": "solid", "region": bodies["a"], "velocity": velocity},
                "b": {"material": "solid", "region": bodies["b"]},
            },
            "contact": [{"bodies": ["a", "b"]}],
        }
    )


def _tilted(middle: np.ndarray, half: np.ndarray, angle: float) -> dict[str, Any]:
    """A rectangle, or a cuboid, turned by `angle` about z."""
    c, s = cos(radians(angle)), sin(radians(angle))
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    parts = []
    for d in range(len(middle)):
        normal = axes[d, : len(middle)]
        for side in (-1.0, 1.0):
            point = middle + side * half[d] * normal
            parts.append(
                {"half-space": {"point": point.tolist(), "normal": (side * normal).tolist()}}
            )
    return {"intersection": parts}


def first_gap(case: Any, gap: float) -> float:
    """Gap left after the step in which bodies first exchange an impulse, in cells."""
    simulation = pgimp.Simulation(case)
    start = gap
    while not simulation.finished:
        simulation.step()
        line = simulation.diagnostics()
        if line["contact.a+b.normal-impulse"] > 0.0:
            return start - SPEED * (simulation.steps - 1)
    return float("nan")


def flat(dimensions: int, angle: float, shift: float) -> float:
    """Two flat faces whose normals are inclined to the grid; `shift` is the place in a cell."""
    way = np.array([cos(radians(angle)), sin(radians(angle)), 0.0])[:dimensions]
    middle = np.full(dimensions, 0.5 * CELLS[dimensions]) + shift * way
    half = np.array([3.0, 4.0, 4.0])[:dimensions]
    gap = 1.5
    bodies = {
        "a": _tilted(middle - 3.0 * way, half, angle),
        "b": _tilted(middle + (3.0 + gap) * way, half, angle),
    }
    return first_gap(_case(dimensions, bodies, way), gap)


def round_(dimensions: int, radius: float, angle: float, shift: float) -> float:
    """Two disks or balls."""
    way = np.array([cos(radians(angle)), sin(radians(angle)), 0.0])[:dimensions]
    middle = np.full(dimensions, 0.5 * CELLS[dimensions]) + shift
    gap = 1.0
    ball = lambda side: {  # noqa: E731
        "ball": {"center": (middle + side * (radius + 0.5 * gap) * way).tolist(), "radius": radius}
    }
    return first_gap(_case(dimensions, {"a": ball(-1.0), "b": ball(1.0)}, way), gap)


def corner(angle: float, shift: float) -> float:
    """A square's corner that comes down on a plane."""
    way = np.array([0.0, -1.0])
    middle, gap = np.array([15.0 + shift, 12.0 + shift]), 1.0
    half = 3.0
    reach = half * (cos(radians(angle)) + sin(radians(angle)))
    bodies = {
        "a": _tilted(middle + np.array([0.0, gap + reach]), np.array([half, half]), angle),
        "b": {"box": {"min": [5.0, 6.0], "max": [25.0, float(middle[1])]}},
    }
    return first_gap(_case(2, bodies, way), gap)


if __name__ == "__main__":
    shifts = np.random.default_rng(1).random(4)
    for angle in (0.0, 10.0, 20.0, 45.0):
        print("flat 2D", angle, [round(flat(2, angle, s), 3) for s in shifts], flush=True)
    for radius in (4.0, 5.0):
        for angle in (0.0, 30.0, 45.0):
            print("disks", radius, angle, [round(round_(2, radius, angle, s), 3) for s in shifts], flush=True)
    for angle in (45.0, 20.0, 30.0):
        print("corner", angle, [round(corner(angle, s), 3) for s in shifts], flush=True)
