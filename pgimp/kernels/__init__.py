"""Numba kernels: transfers, momentum update, canonical order, sums. They know nothing of MPI."""
