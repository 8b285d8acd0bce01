"""Rigid bodies of a scene: motion, mass, distances, warnings."""
