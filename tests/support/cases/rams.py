"""Rigid bodies that move as prescribed, and a block that one of them meets."""

from scenes import box, scene


def rigid(low, high, **motion):
    """A rigid body that fills a box."""
    return {"rigid": motion, "region": {"box": {"min": list(low), "max": list(high)}}}


def struck(D, law, **motion):
    """A block that a rigid body is to meet along x."""
    bodies = {
        "block": box([4.0] + [2.0] * (D - 1), [7.0] + [5.0] * (D - 1)),
        "ram": rigid([1.5] + [1.0] * (D - 1), [4.0] + [6.0] * (D - 1), **motion),
    }
    contact = [{"bodies": ["block", "ram"], **law}]
    return scene(D, bodies, cells=[16, 8, 8][:D], end=1.0, contact=contact)
