"""The solver: particles, grid, the step, and the simulation that drives them."""
