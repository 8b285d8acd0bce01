"""Kernels called once or outside of a run: initial stress, fitted gradients, material elements."""
