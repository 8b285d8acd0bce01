"""Contact of bodies in the initial configuration, at vertices of their current positions."""
