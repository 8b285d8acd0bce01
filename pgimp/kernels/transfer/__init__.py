"""Transfers between a particle and its vertices, (8) to (12): weights, scatter, gather."""
