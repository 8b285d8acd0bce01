"""Contact of bodies by their own surfaces: patches, proximity, pairs."""
