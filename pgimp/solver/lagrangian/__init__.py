"""Bodies in the initial configuration: state at the vertices, cells of the lattice."""
