"""Meshes for tests, as corners of triangles, and cases with bodies that they bound."""

import numpy as np
from scenes import scene

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.geometry import share
from pgimp.scene.scene import Scene


def ball(depth, radius=1.0, centre=(0.0, 0.0, 0.0)):
    """Octahedron whose triangles are divided into four `depth` times, (n, 3, 3)."""
    v = np.vstack([np.eye(3), -np.eye(3)])
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    T = v[faces]
    for _ in range(depth):
        m = 0.5 * (T + np.roll(T, -1, axis=1))
        corners = [np.stack([T[:, i], m[:, i], m[:, i - 1]], axis=1) for i in range(3)]
        T = np.concatenate([*corners, m])
        T /= np.linalg.norm(T, axis=2, keepdims=True)
    return T * radius + np.array(centre)


def torus(n, m, centre=(0.0, 0.0, 0.0)):
    """Torus of radii 1 and 0.4, (2 n m, 3, 3)."""
    a, b = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    across = 1.0 + 0.4 * np.cos(b)
    p = np.stack([across * np.cos(a), across * np.sin(a), 0.4 * np.sin(b)], axis=-1)
    q = [
        np.roll(p, (-i, -j), axis=(0, 1)).reshape(-1, 3)
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    triangles = [np.stack([q[0], q[k], q[k + 1]], axis=1) for k in (1, 2)]
    return np.concatenate(triangles) + np.array(centre)


def volume(T):
    """Volume that triangles enclose, by the divergence theorem."""
    return float(np.einsum("ij,ij->", T[:, 0], np.cross(T[:, 1], T[:, 2])) / 6.0)


def stl(path, T):
    """Write a binary STL file; return the corners as its float32 has them."""
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    data = np.zeros(len(T), row)
    data["corners"] = T
    path.write_bytes(b"made by a test".ljust(80) + np.uint32(len(T)).tobytes() + data.tobytes())
    return data["corners"].astype(float)


def case(region, dimension=3, cell=0.5, **parts):
    """A case of one soft body in the square or cube from -2 to 2."""
    body = {"material": "soft", "region": region}
    cells = [round(4.0 / cell)] * dimension
    found = scene(dimension, body, cells=cells, cell=cell, **parts)
    found["grid"]["origin"] = [-2.0] * dimension
    return found


def filled(region, **parts):
    """Volume, centre of mass and number of a body's particles, and the body's region."""
    model = Case.model_validate(case(region, **parts))
    share(model, Serial())
    scene = Scene(model)
    lattice, counts, notes = count_particles(scene, Serial())
    total, moment, number = 0.0, 0.0, 0
    for made in lattice.make((0, lattice.planes), counts):
        total += made.fractions.sum() * lattice.volume
        moment = moment + (made.fractions[:, None] * made.centroids).sum(axis=0) * lattice.volume
        number += len(made.ids)
    assert number == counts.sum()
    return total, moment / total, number, notes, model.bodies["body"].region
