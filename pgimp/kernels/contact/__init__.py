"""Contact of velocity fields at the vertices of the current configuration."""
