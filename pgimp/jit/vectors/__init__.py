"""Vectors of four float64, and what kernels do with them."""
