"""Order of the particles: layers, cells, migration between layers, the two configurations."""
