"""Entries of a vertex's record of 8 float64, of which the grid's arrays consist.

While particles are summed it holds (m, p) and (0, f); the momentum update turns that into (m, v)
and (h, a). h encodes which components a face or a constraint holds, see
`pgimp.kernels.grid.constraint_flags`.
"""

#: Distance, in float64, of neighbours along the innermost direction.
RECORD = 8

MASS = 0

#: The first of three components.
MOMENTUM = VELOCITY = 1

#: The code of the components that are held.
HELD = 4

#: The first of three components.
FORCE = ACCELERATION = 5
