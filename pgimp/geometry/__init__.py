"""Regions, meshes and clouds of points: inside tests, and volume fractions of boxes."""
