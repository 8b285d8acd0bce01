"""Materials, shapes, boundary conditions, loads and exact solutions, one file each."""
