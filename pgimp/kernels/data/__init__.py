"""Records and named tuples of arrays for kernels: particles, vertices, ledger, arguments."""
