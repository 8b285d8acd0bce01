"""Exact parts of boxes in a tetrahedron: volumes, moments, products, and pieces of its surface."""

import numpy as np

from pgimp.geometry.mesh.facets import facets
from pgimp.geometry.mesh.tree import build_tree

CORNERS = np.array([[0.3, 0.4, 0.2], [2.7, 0.9, 0.5], [0.8, 2.6, 0.7], [1.1, 0.9, 2.8]])
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
TRIANGLES = CORNERS[np.array(FACES)]
EDGES = [np.linspace(0.0, 3.0, n) for n in (7, 6, 5)]


def integrals():
    """Volume, and integrals of x, y, z, yz, xz, xy, xyz over the tetrahedron, in closed form."""
    volume = np.linalg.det(CORNERS[1:] - CORNERS[0]) / 6.0
    x, y, z = CORNERS.T

    def two(f, g):
        return (f.sum() * g.sum() + f @ g) / 20.0

    three = x.sum() * y.sum() * z.sum() + 2.0 * (x * y * z).sum()
    for f, g, h in ((x, y, z), (y, x, z), (z, x, y)):
        three += f.sum() * (g @ h)
    means = [1.0, *CORNERS.mean(axis=0), two(y, z), two(x, z), two(x, y), three / 120.0]
    return volume * np.array(means)


def test_products_of_parts_of_boxes_sum_up_to_the_whole_bodys():
    surface = build_tree(TRIANGLES, np.zeros(4, np.int64), 3)
    shape = tuple(len(e) - 1 for e in EDGES)
    whole, places, volume, moment = surface.fill(EDGES, [(0, n) for n in shape], True)
    parts = np.zeros((whole.size, 8))
    parts[places] = np.concatenate([volume[:, None], moment], axis=1)
    parts[whole, 0] = np.prod([e[1] - e[0] for e in EDGES])
    middle = np.meshgrid(*(0.5 * (e[1:] + e[:-1]) for e in EDGES), indexing="ij")
    x, y, z = (each.reshape(-1) for each in middle)
    V, X, Y, Z, YZ, XZ, XY, XYZ = parts.T
    found = [
        V,
        X + x * V,
        Y + y * V,
        Z + z * V,
        YZ + y * Z + z * Y + y * z * V,
        XZ + x * Z + z * X + x * z * V,
        XY + x * Y + y * X + x * y * V,
        XYZ + x * YZ + y * XZ + z * XY + x * y * Z + x * z * Y + y * z * X + x * y * z * V,
    ]
    np.testing.assert_allclose([each.sum() for each in found], integrals(), rtol=1e-13)
    plain = surface.fill(EDGES, [(0, n) for n in shape])
    np.testing.assert_array_equal(plain[3], moment[:, :3])


def test_pieces_of_a_surface_close_and_have_its_moments():
    """By the divergence theorem: of 1, of y z and x y with the normal's x, and of x y z."""
    box, centre, area, second = facets(TRIANGLES, EDGES)
    for d, edge in enumerate(EDGES):
        assert (centre[:, d] >= edge[box[:, d]] - 1e-12).all()
        assert (centre[:, d] <= edge[box[:, d] + 1] + 1e-12).all()
    whole = integrals()
    x, y, z = centre.T
    along = area[:, 0]
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-13)
    np.testing.assert_allclose((area * centre).sum() / 3.0, whole[0], rtol=1e-13)
    yz, xz, xy, xyz = second.T
    np.testing.assert_allclose((along * (yz + y * z)).sum(), 0.0, atol=1e-13)
    np.testing.assert_allclose((along * (xy + x * y)).sum(), whole[2], rtol=1e-12)
    every = xyz + x * yz + y * xz + z * xy + x * y * z
    np.testing.assert_allclose((along * every).sum(), whole[4], rtol=1e-12)
