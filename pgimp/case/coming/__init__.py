"""Bodies and material that come in the course of a run: checks of their entries."""
