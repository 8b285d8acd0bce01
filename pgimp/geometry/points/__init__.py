"""Particles from CSV and HDF5 files."""
