"""Largest stable Courant numbers, as ``scripts/hard courant`` has measured them.

Of free bodies at many offsets to the grid, by shape and transfer, dimensions and particles per cell
along each direction: see docs/hard-cases.md. A test holds this to the table there.
"""

#: By name of shape, with ", affine" if so; then by dimensions; then by particles per cell.
LIMITS: dict[str, dict[int, dict[int, float]]] = {
}
