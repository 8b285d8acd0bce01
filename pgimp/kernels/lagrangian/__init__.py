"""Bodies in the initial configuration: motion of the vertices, cells of the lattice."""
