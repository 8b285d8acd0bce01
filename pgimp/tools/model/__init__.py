"""What a step costs on any number of ranks: measured here, on one or two, and extrapolated."""
