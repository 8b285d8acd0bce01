"""Largest stable Courant numbers, measured by ``scripts/hard courant``.

For free bodies at many offsets to the grid, by shape and transfer, dimensions and particles per
cell along each direction. A test compares them with the table in docs/hard-cases.md.
"""

#: By name of shape (with ", affine" if affine), dimensions, and particles per cell.
LIMITS: dict[str, dict[int, dict[int, float]]] = {
    "gimp": {1: {1: 0.69, 2: 0.6, 4: 0.48}, 2: {1: 0.63, 2: 0.59, 4: 0.48}, 3: {1: 0.61, 2: 0.56}},
    "finite-gimp": {1: {1: 0.69, 2: 0.6, 4: 0.48}, 2: {1: 0.63, 2: 0.59, 4: 0.48}},
    "fuzzy-nearest": {1: {1: 1.0, 2: 0.78, 4: 0.55}, 2: {1: 0.95, 2: 0.74, 4: 0.55}},
    "fuzzy-constant": {1: {1: 1.0, 2: 1.0, 4: 1.0}, 2: {1: 0.95, 2: 1.0, 4: 1.0}},
    "gimp, affine": {
        1: {1: 0.88, 2: 0.72, 4: 0.52},
        2: {1: 0.85, 2: 0.7, 4: 0.52},
        3: {1: 0.79, 2: 0.66},
    },
    "finite-gimp, affine": {1: {1: 0.88, 2: 0.72, 4: 0.52}, 2: {1: 0.85, 2: 0.7, 4: 0.52}},
    "cpdi": {
        1: {1: 0.73, 2: 0.7, 4: 0.52, 8: 0.35},
        2: {1: 0.73, 2: 0.7, 4: 0.52},
        3: {1: 0.72, 2: 0.72},
    },
    "bspline-quadratic": {1: {1: 0.69, 2: 0.71, 4: 0.75, 8: 0.8}, 2: {1: 0.63, 2: 0.7, 4: 0.71}},
    "bspline-cubic": {1: {1: 1.0, 2: 1.0, 4: 1.0, 8: 1.0}, 2: {1: 0.95, 2: 1.0, 4: 1.0}},
    "cpdi, affine": {
        1: {1: 1.0, 2: 0.94, 4: 0.71, 8: 0.49},
        2: {1: 1.0, 2: 0.93, 4: 0.7},
        3: {1: 0.99, 2: 0.93},
    },
    "bspline-quadratic, affine": {
        1: {1: 0.88, 2: 0.91, 4: 0.91, 8: 0.95},
        2: {1: 0.85, 2: 0.88, 4: 0.87},
    },
    "bspline-cubic, affine": {1: {1: 1.0, 2: 1.0, 4: 1.0, 8: 1.0}, 2: {1: 1.0, 2: 1.0, 4: 1.0}},
}
