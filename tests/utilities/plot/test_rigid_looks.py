"""How rigid bodies are drawn beside planes of symmetry and seams."""

from types import SimpleNamespace

import h5py
import numpy as np

from pgimp.utilities.plot.rigid import lines


def images(folder, edge, mirrored):
    """Edges that are drawn of one between two points, beside particles at (2, 1)."""
    with h5py.File(folder / "rigid-000000.h5", "w") as file:
        file["position"] = np.array([[*point, 0.0] for point in edge])
        file["connectivity"] = np.array([[0, 1]])
    frame = SimpleNamespace(
        path=folder / "particles-000000.h5", rows=lambda *_: np.array([[2.0, 1.0, 0.0]])
    )
    camera = SimpleNamespace(project=lambda position: position)
    edges = lines(frame, camera, (), mirrored)
    return {tuple(map(tuple, np.sort(edge, axis=0).tolist())) for edge in edges}


def test_rigid_bodies_have_images_as_particles_have(tmp_path):
    """An edge from (1, 2) to (3, 2), mirrored at x = 0 and at y = 5."""
    ends = images(tmp_path, [(1.0, 2.0), (3.0, 2.0)], ((0, 0.0), (1, 5.0)))
    assert ends == {((a, y), (b, y)) for a, b in ((1.0, 3.0), (-3.0, -1.0)) for y in (2.0, 8.0)}


def test_rigid_bodies_end_at_planes_of_symmetry(tmp_path):
    """What lies beyond is the image's; what lies in the plane is no edge of the whole body."""
    ends = images(tmp_path, [(-1.0, 2.0), (3.0, 4.0)], ((0, 0.0),))
    assert ends == {((0.0, 2.5), (3.0, 4.0)), ((-3.0, 2.5), (0.0, 4.0))}
    assert not images(tmp_path, [(0.0, 2.0), (0.0, 4.0)], ((0, 0.0),))
    assert not images(tmp_path, [(1.0, 5.0), (2.0, 6.0)], ((1, 5.0 + 1e-12), (1, 4.0)))
