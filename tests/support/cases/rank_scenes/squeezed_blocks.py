"""Every shape whose size is tracked, and all kinds of walls."""

from scenes import box, scene

from rank_scenes.entries import EVERYTHING, turning


def squeezed(dimension, shape, faces, **parts):
    """Two blocks at the ends of the slabs, where mirrors are; the one at x-max hits the other."""
    low, high = [0.0] * dimension, [10.0, *[3.0] * (dimension - 1)]
    velocity = [0.8] * dimension
    bodies = {"wide": box(low, high, velocity)}
    if dimension > 1:
        start = [14.0, *[3.5] * (dimension - 1)]
        hit = box(start, [16.0, *[5.5] * (dimension - 1)], [-8.0, *[-2.5] * (dimension - 1)])
        rate = 0.5 if dimension == 2 else [0.2, 0.4, 0.5]
        bodies["hits"] = turning(hit, [c + 1.0 for c in start], rate, hit["velocity"])
    else:
        bodies["hits"] = box([14.0], [16.0], [-8.0])
    return scene(
        dimension,
        bodies,
        cells=[16, 8, 8][:dimension],
        shape=shape,
        per_cell=2 if dimension < 3 else 1,
        end=0.72,
        step={"courant": 0.25},
        gravity=[0.0] * (dimension - 1) + [-1.0],
        boundaries=faces,
        output={"every": 0.24, "fields": EVERYTHING, "grid": ["mass", "velocity", "force"]},
        history={"every": 0.12},
        probes={
            "corner": {"body": "hits", "at": bodies["hits"]["region"]["box"]["max"]},
            "between": {"place": [12.0, *[3.0] * (dimension - 1)], "every": {"steps": 4}},
        },
        **parts,
    )


#: The shapes whose size is tracked, and tents that stay; mirrors at x-min, x-max and elsewhere.
SIZED = {
    "line_fuzzy": squeezed(1, "fuzzy-constant", {"x-min": "fixed", "x-max": "unilateral"}),
    "plane_finite": squeezed(2, "finite-gimp", {"x-min": "slip", "y-min": "unilateral"}),
    "plane_corners": squeezed(
        2, "cpdi-corners", {"x-min": "slip", "y-min": "unilateral"}, wall="mirror"
    ),
    "space_corners": squeezed(3, "cpdi-corners", {"x-min": "fixed", "z-min": "slip"}),
    "plane_fuzzy": squeezed(
        2, "fuzzy-nearest", {"x-min": "slip", "x-max": "unilateral", "y-min": "unilateral"}
    ),
    "plane_ghost": squeezed(2, "bspline-cubic", {"x-min": "slip", "y-min": "fixed"}, wall="ghost"),
    "plane_mirror": squeezed(
        2, "gimp", {"x-min": "slip", "x-max": "unilateral", "y-min": "unilateral"}, wall="mirror"
    ),
    "space_finite": squeezed(3, "finite-gimp", {"x-min": "fixed", "z-min": "slip"}),
    "space_fuzzy": squeezed(
        3, "fuzzy-constant",
        {"x-min": "fixed", "x-max": "unilateral", "y-min": "slip", "z-min": "fixed"},
        size="fixed",
    ),
}  # fmt: skip
#: Long enough for looks at the energy, and for three checkpoints.
SIZED["plane_mirror"]["time"] = {"end": 2.4, "step": {"courant": "auto"}}
