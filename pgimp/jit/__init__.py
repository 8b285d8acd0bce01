"""How kernels are compiled and kept, vectors of four numbers, and tensor algebra on tuples."""
