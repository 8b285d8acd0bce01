"""Motion of bodies, as far as a case alone tells it."""
