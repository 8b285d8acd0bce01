"""Impulses that are found together: pairs, rows of their velocities, rigid ends, warm starts."""
