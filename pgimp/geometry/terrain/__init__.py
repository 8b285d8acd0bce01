"""Terrain: heights on a grid of places, read from files and closed to a body's surface."""
