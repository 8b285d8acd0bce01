"""Compiled kernels on disk: their folder's name, and trusted files."""
