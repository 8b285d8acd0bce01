"""Contact of bodies in the initial configuration, at the vertices where they are now."""
