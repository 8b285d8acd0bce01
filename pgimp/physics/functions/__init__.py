"""Functions of one's own in a case: body forces, velocities, stresses, coefficients, solutions."""
