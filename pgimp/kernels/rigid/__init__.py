"""Rigid bodies on the grid: signed distances, filled parts, particles held out."""
