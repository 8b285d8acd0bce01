"""Many bodies under contact: disks that fly about and meet, few to ten thousand of them."""

import argparse
from math import ceil, sqrt

import numpy as np
from report import error, markdown, number
from workers.clock import clock

import pgimp

#: Cells, distance of the disks' centres, and their radius: three to four cells across.
CELL, PITCH, RADIUS = 0.012, 0.066, 0.030
WALL = 0.06


def scene(count):
    """A case of disks on a lattice, with random velocities of up to 1 m/s."""
    side = ceil(sqrt(count))
    width = ceil((side * PITCH + 2.0 * WALL) / CELL) * CELL
    random = np.random.default_rng(count)
    bodies = {}
    for n in range(count):
        centre = [WALL + PITCH * (n % side + 0.5), WALL + PITCH * (n // side + 0.5)]
        region = {"ball": {"center": centre, "radius": RADIUS}}
        velocity = random.uniform(-1.0, 1.0, 2).tolist()
        bodies[f"disk{n}"] = {"material": "gel", "region": region, "velocity": velocity}
    gel = {"model": "neo-hookean", "young": 2.0e5, "poisson": 0.3, "density": 1000.0}
    return pgimp.load({
        "format": 1, "dimensions": 2,
        "grid": {"origin": [0.0, 0.0], "size": [width] * 2, "cell": [CELL] * 2},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2], "affine": True},
        "time": {"end": 1.0, "step": 2.5e-4}, "materials": {"gel": gel}, "bodies": bodies,
        "contact": [{"bodies": "all", "friction": 0.5}],
    })  # fmt: skip


def momentum(sim):
    """Momentum, (2,), and the sum of what the particles have of it."""
    p = sim.particles
    rows = sim.live()
    each = p.m[rows, None] * p.v[rows]
    return each.sum(axis=0), np.linalg.norm(each, axis=1).sum()


def measure(count, steps):
    """A row of the table."""
    case = scene(count)
    began = clock()
    sim = pgimp.Simulation(case)
    start = clock() - began
    before, size = momentum(sim.core)
    sim.step(20)  # until many meet
    began = clock()
    sim.step(steps)
    speed = len(sim.core.live()) * steps / (clock() - began)
    change = np.abs(momentum(sim.core)[0] - before).max() / size
    return {"bodies": count, "particles": len(sim.core.live()), "start": start / count,
            "speed": speed, "error": change}  # fmt: skip


def main():
    parser = argparse.ArgumentParser(prog="bodies.py")
    parser.add_argument("--quick", action="store_true", help="few bodies")
    quick = parser.parse_args().quick
    counts, steps = ((20, 50), 5) if quick else ((200, 2000, 10000), 40)
    rows = [measure(count, steps) for count in counts]
    columns = {
        "disks": lambda row: f"{row['bodies']:,}",
        "particles": lambda row: f"{row['particles']:,}",
        "start, ms a disk": lambda row: number(1e3 * row["start"]),
        "million particle-steps/s": lambda row: number(row["speed"] / 1e6),
        "change of momentum": lambda row: error(row["error"]),
    }
    print("Disks of 100 particles that fly about and meet, on one core. The change of the momentum")
    print(f"is over the sum of all particles' momenta, after {20 + steps} steps.\n")
    print(markdown(columns, rows))


if __name__ == "__main__":
    main()
