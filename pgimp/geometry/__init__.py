"""Regions, meshes and clouds of points: what is inside, and how much of a box."""
