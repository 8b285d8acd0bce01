"""Rigid bodies on the grid: signed distances, what they fill, particles that they hold out."""
