"""Frames of particles and their XDMF."""
