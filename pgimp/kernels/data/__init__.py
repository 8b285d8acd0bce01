"""Records and named tuples of arrays that kernels take: particles, vertices, ledger, arguments."""
