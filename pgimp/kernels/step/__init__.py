"""The loops of a step over particles and vertices: sums, momentum, gather, checks."""
