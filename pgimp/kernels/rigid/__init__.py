"""Rigid bodies on the grid: signed distances, motion, their impulses."""
