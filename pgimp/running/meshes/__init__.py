"""Frames of meshes: of the grid, of rigid bodies, and of surfaces that meet."""
