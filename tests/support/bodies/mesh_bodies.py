"""A body made of a mesh file, and the mesh of a ball."""

from meshes import ball

BALL = ball(3, 1.3, (0.1, 0.05, -0.2))


def mesh(path, **more):
    return {"mesh": {"file": str(path), **more}}
