"""Vectors of four float64, and operations on them in kernels."""
