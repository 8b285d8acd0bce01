"""Regions as cases write them, by hand and at random."""

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st
from pydantic import TypeAdapter

from pgimp.geometry.regions import RegionEntry

ENTRY = TypeAdapter(RegionEntry)


def region(**entry):
    return ENTRY.validate_python(entry)


def box(low, high):
    return {"box": {"min": low, "max": high}}


def ball(centre, radius):
    return {"ball": {"centre": centre, "radius": radius}}


def cylinder(start, end, radius):
    return {"cylinder": {"from": start, "to": end, "radius": radius}}


def half_space(point, normal):
    return {"half-space": {"point": point, "normal": normal}}


@st.composite
def entries(draw, dimensions, depth=2):
    """Regions of any kind."""
    vector = st.lists(st.floats(-10, 10), min_size=dimensions, max_size=dimensions)
    length = st.floats(0.1, 5)
    kinds = ["box", "ball", "half-space"] + ["cylinder"] * (dimensions == 3)
    kinds += ["union", "difference", "intersection"] * (depth > 0)
    kind = draw(st.sampled_from(kinds))
    if kind == "box":
        low = draw(vector)
        return box(low, [x + draw(length) for x in low])
    if kind == "ball":
        return ball(draw(vector), draw(length))
    if kind == "half-space":
        normal = draw(vector)
        keep = draw(st.integers(0, dimensions))  # across an axis often
        normal = [x * (keep in (i, dimensions)) for i, x in enumerate(normal)]
        assume(np.linalg.norm(normal) > 0.1)
        return half_space(draw(vector), normal)
    if kind == "cylinder":
        start = draw(vector)
        return cylinder(start, [start[0] + draw(length), *draw(vector)[1:]], draw(length))
    return {kind: draw(st.lists(entries(dimensions, depth - 1), min_size=2, max_size=3))}
