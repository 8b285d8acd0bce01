"""Grains for drum.yaml: `python cases/drum.py` writes their lines, for other numbers and sizes too.

Disks of different radii lie in a round drum, each at the lowest place that touches two of those
placed before, or one and the drum: a dense heap, in which nothing has to fall first.
"""

import argparse

import numpy as np

GAP = 1.0e-4  # between neighbours, as places are rounded


def places(circles):
    """Centres at the distances in the third column from the centres of each two of the circles."""
    first, second = np.triu_indices(len(circles), 1)
    way = circles[second, :2] - circles[first, :2]
    apart = np.hypot(*way.T)
    near, far = circles[first, 2], circles[second, 2]
    touch = (apart < near + far) & (apart > np.abs(near - far))
    first, way, apart, near, far = (part[touch] for part in (first, way, apart, near, far))
    along = (apart**2 + near**2 - far**2) / (2.0 * apart)
    across = np.sqrt(near**2 - along**2)
    way /= apart[:, None]
    middle = circles[first, :2] + along[:, None] * way
    side = across[:, None] * np.stack([-way[:, 1], way[:, 0]], axis=1)
    return np.concatenate([middle - side, middle + side])


def lowest(disks, radius, drum):
    """The lowest centre of a disk that touches two of the disks, or one and the drum."""
    circles = np.vstack([disks, [0.0, 0.0, drum]])
    circles[:, 2] += radius + GAP
    circles[-1, 2] = drum - radius - GAP
    centres = places(circles)
    centres = centres[np.hypot(*centres.T) < drum - radius - 0.9 * GAP]
    for part in np.split(centres[centres[:, 1].argsort()], range(50, len(centres), 50)):
        apart = np.hypot(*(part[:, None, :] - disks[None, :, :2]).T)
        free = (apart > disks[:, 2, None] + radius + 0.9 * GAP).all(axis=0)
        if free.any():
            return part[free.argmax()]
    raise SystemExit(f"drum.py: {len(disks)} grains fill the drum")


def heap(count, mean, spread, drum, seed):
    """Rows of x, y and radius of `count` disks with radii from `mean` - `spread` to + `spread`."""
    random = np.random.default_rng(seed)
    radii = np.round(mean + spread * random.uniform(-1.0, 1.0, count), 3)
    disks = np.array([[0.0, -drum + radii[0] + GAP, radii[0]]])
    for radius in radii[1:]:
        disks = np.vstack([disks, [*lowest(disks, radius, drum), radius]])
    return disks


def main():
    """Write the lines."""
    parser = argparse.ArgumentParser(prog="drum.py")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--radius", type=float, default=0.03, help="mean of the grains")
    parser.add_argument("--spread", type=float, default=0.006, help="greatest difference from it")
    parser.add_argument("--drum", type=float, default=0.66, help="inner radius of the drum")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    disks = heap(given.count, given.radius, given.spread, given.drum, given.seed)
    for number, (x, y, radius) in enumerate(disks, 1):
        ball = f"{{centre: [{x:.4f}, {y:.4f}], radius: {radius:.3f}}}"
        print(f"  g{number:03d}: {{material: gel, surface: whole-particles,")
        print(f"         region: {{ball: {ball}}}}}")


if __name__ == "__main__":
    main()
