"""Loads and prescribed motion: their entries in the case, and what kernels get of them."""
