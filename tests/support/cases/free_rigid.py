"""Rigid bodies that move freely, and a block that one of them meets."""

import numpy as np
from scenes import box, scene


def free(low, high, density=1.0, velocity=None, **more):
    """A free rigid body that fills a box."""
    body = {"rigid": {"density": density, **more}, "region": {"box": {"min": low, "max": high}}}
    return body if velocity is None else body | {"velocity": velocity}


def configured(case, configuration, *names):
    """The case with some bodies of a material, or all, in a configuration."""
    for name, body in case["bodies"].items():
        if "rigid" not in body and (name in names or not names):
            body["formulation"] = configuration
    return case


def momenta(line, name=None):
    """Momentum along x, y, z, and angular momentum about them, of a body or of all particles."""
    of = f"rigid.{name}." if name else ""
    columns = [f"{of}{what}-{a}" for what in ("momentum", "angular-momentum") for a in "xyz"]
    return np.array([line.get(column, 0.0) for column in columns])


def struck(D, law, density, **parts):
    """A block that a free body meets askew along x."""
    bodies = {
        "block": box([4.0] + [2.0] * (D - 1), [7.0] + [5.0] * (D - 1)),
        "ball": free([1.0] + [2.3] * (D - 1), [3.7] + [4.4] * (D - 1), density,
                     [1.0, 0.3, -0.2][:D]),
    }  # fmt: skip
    contact = [{"bodies": ["block", "ball"], **law}]
    # Nothing comes near the wall, with which the kernels are those of other tests.
    parts = ({"boundaries": {"y-max": "slip"}} if D > 1 else {}) | parts
    return scene(D, bodies, cells=[16, 9, 9][:D], end=1.5, contact=contact, **parts)
