"""Entries of a vertex's record of 8 float64, the unit of the grid's arrays.

During P2G it holds (m, p) and (0, f), or (s, f) with a sum s for clearances; the momentum update
turns these into (m, v) and (h, a). h encodes the components held by a face or a constraint, see
`pgimp.kernels.grid.constraint_flags`.
"""

#: Distance, in float64, of neighbours along the innermost direction.
RECORD = 8

MASS = 0

#: The first of three components.
MOMENTUM = VELOCITY = 1

#: One entry with three meanings, one after the other: the sum for the clearances of
#: `pgimp.kernels.loads.wall_gap`; beyond a mirror, once folded, the mass; the code of the held
#: components.
CLEARANCE_SUM = FOLDED_MASS = HELD = 4

#: The first of three components.
FORCE = ACCELERATION = 5
