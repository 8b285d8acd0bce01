"""A block with all loads at once, and the constraints of such scenes."""

from scenes import box, scene


def grip(low, high, *velocity, body="body"):
    """A constraint on what lies in a box; rows of a table or None where it is free."""
    given = [{"table": v} if isinstance(v, list) else v for v in velocity]
    return {"body": body, "region": {"box": {"min": low, "max": high}}, "velocity": given}


def loaded(**parts):
    """A block with all loads at once, on the move through the layers, dragged along a wall."""
    constraints = {
        "pull": grip([7.0, 0.0], [8.0, 4.0], 3.0, None),
        "lift": grip([6.5, 2.0], [7.0, 4.0], None, [[0.0, 0.0], [0.5, 1.0]]),
    }
    tractions = {
        "top": {"body": "body", "face": "y-max", "traction": {"table": [[0, [0, 0]], [1, [1, 4]]]}},
        "back": {"body": "body", "face": "x-min", "pressure": 2.0},
    }
    soft = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
    given = {
        "materials": {"soft": soft | {"viscosity": {"linear": 0.2, "quadratic": 2.0}}},
        "cells": [16, 8],
        "gravity": [0.0, -2.0],
        "boundaries": {"y-min": "slip"},
        "tractions": tractions,
        "constraints": constraints,
        "end": 1.0,
        "history": {"every": {"steps": 10}},
        "output": {"every": 0.5, "fields": ["velocity", "stress", "deformation"]},
    }
    return scene(2, box([2.1, 0.0], [8.0, 4.0], [2.0, 0.0]), **{**given, **parts})
