"""Impulses of all pairs in scenes with an initial configuration: sweeps, kept forces, bonds."""
