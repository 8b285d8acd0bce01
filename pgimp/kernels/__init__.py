"""Numba kernels: transfers, momentum update, canonical order, sums; without MPI."""
