"""Contact of bodies by their own surfaces: gaps, shares of patches, rows."""
