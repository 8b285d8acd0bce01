"""Transfers between particles and vertices, (8) to (12): weights, scatter, gather, layered sums."""
