"""Cost of a step on any number of ranks: measured here, on one or two, and extrapolated."""
