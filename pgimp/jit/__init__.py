"""Compiling and caching of kernels, vectors of four numbers, and tensor algebra on tuples."""
